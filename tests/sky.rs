//! The sky and the sun against tests/data/preetham_reference.json: float64 values of the authors' coefficients,
//! checked there against a 40-digit evaluation to 2.4e-15.

use std::f64::consts::PI;

use glam::DVec3;
use serde_json::Value;
use terrane::scene::Sky;
use terrane::sky::{preetham, sun};

fn reference() -> Value {
    let text = include_str!("data/preetham_reference.json");
    serde_json::from_str(text).expect("the reference is JSON")
}

fn number(value: &Value) -> f64 {
    value.as_f64().unwrap_or_else(|| panic!("not a number: {value}"))
}

/// A unit vector in the sun's meridian turned by `dphi`; world axes, the sun towards −z.
fn direction(theta: f64, dphi: f64) -> DVec3 {
    DVec3::new(dphi.sin() * theta.sin(), theta.cos(), -dphi.cos() * theta.sin())
}

fn relative(found: f64, expected: f64) -> f64 {
    (found - expected).abs() / expected.abs().max(1e-300)
}

/// Largest relative difference over all cases of `table`, for coefficients from `turbidity · scale`.
fn worst_difference(table: &str, scale: f64) -> f64 {
    let mut worst = 0.0f64;
    for case in reference()[table].as_array().expect("a list of cases") {
        let theta_sun = number(&case["theta_s_deg"]).to_radians();
        let view = direction(number(&case["theta_deg"]).to_radians(), number(&case["dphi_deg"]).to_radians());
        let perez = preetham::perez(number(&case["T"]) * scale, direction(theta_sun, 0.0));
        let [luminance, x, y] = perez.luminance_and_chromaticity(view).expect("above the horizon");
        worst = worst.max(relative(luminance / 1000.0, number(&case["Y_kcd"])));
        worst = worst.max(relative(x, number(&case["x"]))).max(relative(y, number(&case["y"])));
        let largest = case["linear_srgb"].as_array().expect("three channels").iter().map(number);
        let largest = largest.fold(0.0f64, |most, channel| most.max(channel.abs()));
        for (found, expected) in perez.radiance(view).iter().zip(case["linear_srgb"].as_array().unwrap()) {
            worst = worst.max((found / 1000.0 - number(expected)).abs() / largest);
        }
    }
    worst
}

#[test]
fn sky_agrees_with_the_reference() {
    let worst = worst_difference("sky", 1.0);
    assert!(worst < 1e-12, "largest relative difference {worst:e}");
}

#[test]
fn sky_near_the_sun_agrees_with_the_reference() {
    let worst = worst_difference("sky_near_sun", 1.0);
    assert!(worst < 1e-12, "largest relative difference {worst:e}");
}

#[test]
fn a_slightly_wrong_turbidity_is_caught() {
    assert!(worst_difference("sky", 1.0 + 1e-9) > 1e-12);
}

#[test]
fn sky_is_black_below_the_horizon_and_lit_from_it_at_night() {
    let Sky::Preetham(perez) = preetham::sky(3.0, DVec3::new(0.6, -0.8, 0.0)) else { panic!("no sky") };
    assert_eq!(perez.sun, DVec3::X);
    assert_eq!(perez.radiance(DVec3::new(0.6, -0.8, 0.0)), [0.0; 3]);
    assert!(perez.radiance(DVec3::Y).iter().all(|channel| channel.is_finite() && *channel > 0.0));
}

#[test]
fn sun_position_agrees_with_the_formulas_and_an_almanac() {
    for case in reference()["solar_position"]["cases"].as_array().expect("a list of cases") {
        let place = sun::Place {
            latitude: number(&case["lat_deg"]).to_radians(),
            longitude: number(&case["lon_east_deg"]).to_radians(),
            utc_offset: number(&case["utc_offset_h"]),
            day: number(&case["julian_day"]),
            time: number(&case["time_h"]),
        };
        let position = sun::Position::at(&place);
        let expected = &case["preetham"];
        let zenith = (position.zenith.to_degrees() - number(&expected["zenith_deg"])).abs();
        assert!(zenith < 1e-9, "{place:?}: zenith off by {zenith:e}°");
        let turn = position.azimuth - number(&expected["azimuth_from_north_cw_deg"]).to_radians();
        let turn = ((turn + PI).rem_euclid(2.0 * PI) - PI).abs().to_degrees();
        assert!(turn < 1e-9, "{place:?}: azimuth off by {turn:e}°");
        // The authors' axes are x south, y east, z up.
        let axes = expected["to_sun_x_south_y_east_z_up"].as_array().expect("three components");
        let to_sun = DVec3::new(number(&axes[1]), number(&axes[2]), number(&axes[0]));
        assert!(position.direction().distance(to_sun) < 1e-12);
        let almanac = &case["pvlib_2023"];
        let almanac = sun::Position {
            zenith: number(&almanac["zenith_deg"]).to_radians(),
            azimuth: number(&almanac["azimuth_from_north_cw_deg"]).to_radians(),
        };
        let separation = position.direction().angle_between(almanac.direction()).to_degrees();
        assert!(separation < 1.15, "{place:?}: {separation}° from the almanac");
    }
}

#[test]
fn sun_disc_agrees_with_the_reference() {
    for case in reference()["sun_disc"]["cases"].as_array().expect("a list of cases") {
        let (turbidity, zenith) = (number(&case["T"]), number(&case["theta_s_deg"]).to_radians());
        assert!(relative(sun::optical_mass(zenith), number(&case["optical_mass"])) < 1e-12);
        for (wavelength, expected) in case["radiance_W_m2_nm_sr"].as_object().expect("wavelengths") {
            let wavelength = wavelength.parse().expect("nanometres");
            let found = sun::disc_spectral_radiance(turbidity, zenith, wavelength);
            let off = relative(found, number(expected));
            assert!(off < 1e-12, "T {turbidity}, {wavelength} nm: off by {off:e}");
        }
        let [x, y, z] = sun::disc_radiance_xyz(turbidity, zenith);
        assert!(relative(y, number(&case["luminance_cd_m2"])) < 1e-9);
        assert!(relative(x / (x + y + z), number(&case["x"])) < 1e-9);
        assert!(relative(y / (x + y + z), number(&case["y"])) < 1e-9);
        // The reference rounds the solid angle to 6.7443e-5 sr.
        assert!(relative(y * sun::SOLID_ANGLE / 1000.0, number(&case["normal_illuminance_klx"])) < 1e-5);
    }
}

#[test]
fn an_overhead_sun_gives_101_kilolux_and_a_set_sun_nothing() {
    let overhead = sun::sun(sun::Position { zenith: 0.0, azimuth: 0.0 }, 2.0).expect("a sun");
    assert!((terrane::core::color::luminance(overhead.irradiance) - 100_977.0).abs() < 100.0);
    assert_eq!(overhead.direction, glam::Vec3::Y);
    assert_eq!(sun::sun(sun::Position { zenith: PI / 2.0, azimuth: 0.0 }, 2.0), None);
}
