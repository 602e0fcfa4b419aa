//! Sun, sky and air, and what they fall on.

use super::Check;
use crate::formats::{self, Panorama};
use crate::scene::{self, SkyMap};
use crate::sky;
use crate::world::fault::{Cause, Complaint};
use crate::world::keys;
use crate::world::place::{KeyPath, shown};
use glam::DVec3;
use std::sync::Arc;

impl Check<'_> {
    pub(super) fn light(&mut self, world: &keys::World) -> scene::Light {
        let turbidity = match &world.sky {
            keys::Sky::Preetham(preetham) => preetham.turbidity,
            keys::Sky::HosekWilkie(model) => model.turbidity,
            // Only the sun's strength asks for it: a clear day.
            _ => 3.0,
        };
        let turbidity = f64::from(turbidity);
        let (direction, sun) = match &world.sun {
            keys::Sun::None => (DVec3::Y, None),
            keys::Sun::Place(place) => self.sun_of_place(place, turbidity),
            keys::Sun::Direct(sun) => {
                let zenith = std::f64::consts::FRAC_PI_2 - f64::from(sun.elevation);
                let direction = sky::sun::Position { zenith, azimuth: sun.azimuth.into() }.direction();
                let &keys::SunDirect { irradiance, diameter, .. } = sun;
                (direction, Some(scene::Sun { direction: direction.as_vec3(), irradiance, diameter }))
            }
        };
        let sky = match &world.sky {
            keys::Sky::None => scene::Sky::None,
            keys::Sky::Constant(constant) => scene::Sky::Constant { radiance: constant.radiance },
            keys::Sky::Preetham(_) => {
                self.warn_of_sky(turbidity, direction);
                sky::preetham::sky(turbidity, direction)
            }
            keys::Sky::HosekWilkie(model) => {
                sky::hosek_wilkie::sky(turbidity, model.albedo.into(), direction)
            }
            keys::Sky::Map(map) => self.sky_map(map),
        };
        let clouds = match &world.sky {
            keys::Sky::Preetham(preetham) => preetham.clouds,
            keys::Sky::HosekWilkie(model) => model.clouds,
            _ => 0.0,
        };
        scene::Light { sky, sun, air: world.render.aerial.then(|| sky::air::air(turbidity)), clouds }
    }

    fn sun_of_place(&mut self, place: &keys::SunPlace, turbidity: f64) -> (DVec3, Option<scene::Sun>) {
        let position = sky::sun::Position::at(&sky::sun::Place {
            latitude: place.latitude.into(),
            longitude: place.longitude.into(),
            utc_offset: place.utc_offset.into(),
            day: place.day.into(),
            time: place.time.into(),
        });
        let sun = sky::sun::sun(position, turbidity);
        if sun.is_none() {
            let below = position.zenith.to_degrees() - 90.0;
            self.warnings.push(format!(
                "the sun stands {below:.1} degrees below the horizon: there is no sun, and the sky has the light of sunset; \
                 change `sun.place.time` or `sun.place.utc_offset`"
            ));
        }
        (position.direction(), sun)
    }

    fn sky_map(&mut self, written: &keys::SkyMap) -> scene::Sky {
        let keys::SkyMap { file: Some(path), scale, rotation } = written else {
            // That it is missing was noted.
            return scene::Sky::None;
        };
        match formats::read_sky(&self.folder.join(path)) {
            Ok(Panorama { size: [width, height], mut pixels }) => {
                pixels.iter_mut().flatten().for_each(|channel| *channel = (*channel * scale).min(1e30));
                let map = SkyMap { width, height, texels: pixels, rotation: f64::from(*rotation) };
                scene::Sky::Map(Arc::new(map.reduced()))
            }
            Err(error) => {
                let place = KeyPath::from("sky.map.file");
                let cause =
                    if matches!(error, formats::Error::NoSky { .. }) { Cause::World } else { Cause::File };
                let complaint = Complaint::new(format!("names \"{}\"", shown(path)), error.to_string());
                self.refuse(std::slice::from_ref(&place), Complaint { cause, ..complaint });
                scene::Sky::None
            }
        }
    }

    fn warn_of_sky(&mut self, turbidity: f64, sun: DVec3) {
        if !(2.0..=8.0).contains(&turbidity) {
            self.warnings.push(format!(
                "`sky.preetham.turbidity` is {turbidity}; the model is good from 2 to 8, and wrong near the horizon elsewhere"
            ));
        }
        let elevation = 90.0 - sun.y.clamp(-1.0, 1.0).acos().to_degrees();
        if (0.0..3.0).contains(&elevation) {
            self.warnings.push(format!(
                "the sun stands {elevation:.1} degrees high; below 3 the sky of Preetham 1999 is too bright"
            ));
        }
    }

    pub(super) fn surface(&mut self, surface: &scene::Surface) {
        let mut rows = vec![("rock_slope", surface.rock_slope), ("dry_height", surface.dry_height)];
        if let Some(snow) = &surface.snow {
            rows.extend([("snow.height", snow.height), ("snow.slope", snow.slope)]);
        }
        for (name, [begin, end]) in rows {
            if begin >= end {
                let place = name.split('.').fold(KeyPath::from("surface"), |place, part| place.join(part));
                self.refuse(&[place], Complaint::new("must rise", "the first number below the second"));
            }
        }
        if let Some(scene::ByHeight { rock_start, ground_end, .. }) = surface.by_height
            && ground_end <= rock_start
        {
            let place = KeyPath::from("surface.by_height");
            let complaint = Complaint::new("must lie above `rock_start`", format!("{rock_start} m and more"));
            self.refuse(&[place.join("ground_end"), place.join("rock_start")], complaint);
        }
    }
}
