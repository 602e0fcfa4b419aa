//! The air between the eye and the ground: how much of it a turbidity means.

use crate::scene::{Air, AirLayer};

/// Molecules and haze of a sky of this `turbidity`, each thinning exponentially with height.
///
/// Turbidity is *defined* as the optical depth of molecules and haze over that of molecules alone
/// (Preetham et al. 1999, section 2), which fixes the haze once its scale height is known. Scale heights are
/// the paper's (section 3.2: α = 0.8333e-3 and 0.1136e-3 1/m). Over the open ocean most of a column's haze floats
/// above the layer that mixes with the surface; only a share of it veils the view.
pub fn air(turbidity: f64) -> Air {
    let molecules = MOLECULES.map(|scattering| scattering as f32);
    let haze = LOW_SHARE * (turbidity - 1.0).max(0.0) * MOLECULES[1] * MOLECULE_HEIGHT / HAZE_HEIGHT;
    Air {
        molecules: AirLayer { extinction: molecules, scale_height: MOLECULE_HEIGHT as f32 },
        haze: AirLayer { extinction: [haze as f32; 3], scale_height: HAZE_HEIGHT as f32 },
    }
}

/// Share of the haze in the lowest layer. A turbidity of 2.2 then leaves 0.04 of optical depth there: remote
/// maritime air has 0.03 to 0.1 in the whole column (Smirnov et al. 2009, "Maritime Aerosol Network").
const LOW_SHARE: f64 = 0.3;

/// Rayleigh scattering at sea level for red, green and blue (680, 550 and 440 nm), 1/m
/// (Bruneton & Neyret 2008, section 4).
const MOLECULES: [f64; 3] = [5.8e-6, 13.5e-6, 33.1e-6];
const MOLECULE_HEIGHT: f64 = 1.0 / 0.1136e-3;
const HAZE_HEIGHT: f64 = 1.0 / 0.8333e-3;
