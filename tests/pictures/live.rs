//! Scenes that are drawn again and again: the same pictures as those that are drawn once, what changes, and false colours.

use crate::kit;
use crate::kit::scenery::{island, sandbox, straight_down};
use crate::kit::stage;
use glam::Vec3;
use image::RgbImage;
use std::sync::{Arc, OnceLock};
use std::time::Duration;
use terrane::core::grid::Grid;
use terrane::gpu::{Gpu, Image, Recorder, format::R32f, format::Rgba8, format::Rgba32f};
use terrane::raster::{
    COLOURS, Detail, Live, MATERIALS, Overlay, Quality, Renderer, Scale, Shown, View, overlay_colour,
};
use terrane::scene::{Camera, Developer, Development, Film, Instance, Picture, Scene, ToneMap};

fn renderer(gpu: &Gpu) -> Arc<Renderer> {
    static SHARED: OnceLock<Arc<Renderer>> = OnceLock::new();
    SHARED.get_or_init(|| Arc::new(Renderer::new(gpu).expect("a renderer"))).clone()
}

fn film(width: u32, height: u32) -> Film {
    Film { width, height, exposure: 6e-5, tone_map: ToneMap::Filmic }
}

fn texels(gpu: &Gpu, image: &Image<Rgba8>) -> Vec<[u8; 4]> {
    let mut rec = Recorder::new(gpu);
    let download = rec.download(image);
    download.take(&rec.submit().expect("submitted").wait().expect("finished"))
}

fn lit(live: &mut Live) {
    while live.relight(Duration::from_millis(20)).expect("light") {}
    assert!(live.is_lit());
}

fn view(live: &Live, camera: Camera, film: Film, samples: u32, detail: Detail) -> View {
    View { camera: live.stand(camera, &film), film, samples, detail, overlay: None }
}

fn draw(gpu: &Gpu, live: &mut Live, view: &View) -> Vec<[u8; 4]> {
    let target = Image::new(gpu, "target", [view.film.width, view.film.height]).expect("an image");
    live.draw(view, &target).expect("a picture");
    texels(gpu, &target)
}

fn rgb(pixels: &[[u8; 4]], film: &Film) -> RgbImage {
    let bytes = pixels.iter().flat_map(|&[r, g, b, _]| [r, g, b]).collect();
    RgbImage::from_raw(film.width, film.height, bytes).expect("as many pixels")
}

/// The same picture as the renderer draws it for a file.
fn rendered(gpu: &Gpu, scene: &Scene, film: &Film, samples: u32) -> Vec<[u8; 4]> {
    let quality = Quality { samples, tile: 512 };
    let picture = renderer(gpu).render(scene, film, quality).expect("a picture");
    picture.developed(film.tone_map).chunks(3).map(|rgb| [rgb[0], rgb[1], rgb[2], 255]).collect()
}

/// Share of pixels of which a channel differs by more than `most`.
fn differing(one: &[[u8; 4]], other: &[[u8; 4]], most: u8) -> f64 {
    assert_eq!(one.len(), other.len());
    let differ = |(a, b): (&[u8; 4], &[u8; 4])| a.iter().zip(b).any(|(a, b)| a.abs_diff(*b) > most);
    one.iter().zip(other).filter(|pair| differ(*pair)).count() as f64 / one.len() as f64
}

#[test]
fn pictures_are_developed_as_on_the_host() {
    let gpu = kit::gpu();
    let developer = Developer::new(&gpu).expect("a program");
    let (width, height, samples) = (61, 37, 3);
    let texel = |at: u32| -> [f32; 4] {
        // From black through white to what is far beyond it, of every hue, and some that no picture should hold.
        let unit = |stream: u32| terrane::core::hash::mix(at * 4 + stream) as f32 / u32::MAX as f32;
        let brightness = (14.0 * unit(3) - 9.0).exp2();
        [0, 1, 2].map(|stream| brightness * unit(stream)).iter().copied().chain([1.0]).collect::<Vec<_>>()[..]
            .try_into()
            .expect("four")
    };
    let light: Vec<[f32; 4]> = (0..width * height * samples * samples).map(texel).collect();
    let image = Image::<Rgba32f>::new(&gpu, "light", [width * samples, height * samples]).expect("an image");
    let target = Image::<Rgba8>::new(&gpu, "target", [width, height]).expect("an image");
    let exposure = 0.7;
    for tone_map in [ToneMap::None, ToneMap::Filmic] {
        let mut rec = Recorder::new(&gpu);
        rec.upload(&image, &light);
        developer.develop(&mut rec, &image, &target, Development { exposure, tone_map });
        rec.submit().expect("submitted").wait().expect("finished");
        let found = texels(&gpu, &target);
        let mut picture = Picture::new(width, height);
        for (index, pixel) in picture.pixels.iter_mut().enumerate() {
            let (column, row) = (index as u32 % width, index as u32 / width);
            let own = (0..samples * samples).map(|sample| {
                let (x, y) = (column * samples + sample % samples, row * samples + sample / samples);
                light[(y * width * samples + x) as usize]
            });
            let sum = own.fold([0.0; 3], |sum: [f32; 3], light| [0, 1, 2].map(|at| sum[at] + light[at]));
            *pixel = sum.map(|channel| channel * exposure / (samples * samples) as f32);
        }
        for (found, expected) in found.iter().zip(picture.developed(tone_map).chunks(3)) {
            assert_eq!(found[3], 255);
            for (found, expected) in found.iter().zip(expected) {
                assert!(found.abs_diff(*expected) <= 1, "{tone_map:?}: {found} in place of {expected}");
            }
        }
    }
}

#[test]
fn what_is_no_light_is_developed_to_something() {
    let gpu = kit::gpu();
    let developer = Developer::new(&gpu).expect("a program");
    let image = Image::<Rgba32f>::new(&gpu, "light", [2, 1]).expect("an image");
    let target = Image::<Rgba8>::new(&gpu, "target", [2, 1]).expect("an image");
    let mut rec = Recorder::new(&gpu);
    rec.upload(&image, &[[f32::INFINITY; 4], [-3.0, f32::NEG_INFINITY, -0.0, 1.0]]);
    let development = Development { exposure: 1.0, tone_map: ToneMap::Filmic };
    developer.develop(&mut rec, &image, &target, development);
    rec.submit().expect("submitted").wait().expect("finished");
    let found = texels(&gpu, &target);
    assert!(found[0].iter().all(|channel| *channel >= 254), "{found:?}");
    assert!(found[1][..3].iter().all(|channel| *channel <= 1), "{found:?}");
}

#[test]
fn a_full_picture_is_the_one_that_is_rendered() {
    let gpu = kit::gpu();
    let scene = island(&gpu, 128);
    let mut live = Live::new(&gpu, renderer(&gpu), scene.clone()).expect("a scene");
    lit(&mut live);
    for (film, samples) in [(film(200, 120), 1), (film(97, 61), 2), (film(50, 40), 3)] {
        let view = view(&live, scene.camera, film, samples, Detail::Full);
        let found = draw(&gpu, &mut live, &view);
        let share = differing(&found, &rendered(&gpu, &scene, &film, samples), 1);
        assert!(share <= 0.001, "{share} of the pixels differ with {samples} samples");
    }
}

#[test]
fn a_swift_picture_looks_like_it() {
    let gpu = kit::gpu();
    let scene = island(&gpu, 256);
    let mut live = Live::new(&gpu, renderer(&gpu), scene.clone()).expect("a scene");
    lit(&mut live);
    let film = film(240, 135);
    let [swift, full] = [Detail::Swift, Detail::Full].map(|detail| {
        let view = view(&live, scene.camera, film, 1, detail);
        rgb(&draw(&gpu, &mut live, &view), &film)
    });
    let difference = kit::picture::flip(&full, &swift);
    assert!(difference < 0.1, "FLIP {difference}");
    // A picture whose camera has moved a little is farther away.
    let mut moved = view(&live, scene.camera, film, 1, Detail::Full);
    moved.camera.eye += 0.1 * moved.camera.eye.length() * moved.camera.right;
    let moved = kit::picture::flip(&full, &rgb(&draw(&gpu, &mut live, &moved), &film));
    assert!(moved > 1.2 * difference, "FLIP {moved} of another view, {difference} of a swift one");
}

#[test]
fn what_changes_is_seen() {
    let gpu = kit::gpu();
    let (old, new) = (island(&gpu, 128), island(&gpu, 128));
    let film = film(160, 100);
    let mut live = Live::new(&gpu, renderer(&gpu), old.clone()).expect("a scene");
    lit(&mut live);
    // Ground, in the same images.
    let grid = old.ground.grid;
    let heights: Vec<f32> =
        kit::island::island(grid).height.iter().map(|height| 0.7 * height + 20.0).collect();
    for ground in [&old.ground, &new.ground] {
        let mut rec = Recorder::new(&gpu);
        rec.upload(&ground.height, &heights);
        rec.submit().expect("submitted").wait().expect("finished");
    }
    live.ground_changed().expect("bounds");
    assert!(!live.is_lit());
    lit(&mut live);
    let check = |live: &mut Live, expected: &Scene, what: &str| {
        let view = view(live, expected.camera, film, 1, Detail::Full);
        let share = differing(&draw(&gpu, live, &view), &rendered(&gpu, expected, &film, 1), 1);
        assert!(share <= 0.001, "{what}: {share} of the pixels differ");
    };
    check(&mut live, &new, "ground");
    let mut scene = new;
    scene.light.sun = None;
    scene.light.clouds = 0.9;
    live.set_light(scene.light.clone()).expect("light");
    lit(&mut live);
    check(&mut live, &scene, "light");
    scene.sea.deep_colour = [0.1, 0.02, 0.02];
    live.set_sea(scene.sea);
    lit(&mut live);
    check(&mut live, &scene, "sea");
    scene.surface.grass = [0.3, 0.02, 0.02];
    live.set_surface(scene.surface.clone());
    lit(&mut live);
    check(&mut live, &scene, "surface");
    scene.population = kit::forest::standing(
        kit::forest::tree(1, 300.0, 400),
        (0..40).map(|at| Vec3::new(60.0 * (at % 8) as f32 - 240.0, 300.0, 60.0 * (at / 8) as f32)),
    );
    live.set_population(scene.population.clone());
    check(&mut live, &scene, "population");
    // Others of the same model, with shadows.
    let moved = |instance: &Instance| Instance { position: instance.position + Vec3::X * 33.0, ..*instance };
    scene.population.instances = scene.population.instances.iter().map(moved).collect();
    live.set_population(scene.population.clone());
    scene.light.sun = old.light.sun;
    live.set_light(scene.light.clone()).expect("light");
    lit(&mut live);
    check(&mut live, &scene, "other places");
    // Another grid.
    let other = island(&gpu, 96);
    scene.ground = other.ground;
    live.set_ground(scene.ground.clone()).expect("ground");
    lit(&mut live);
    check(&mut live, &scene, "another grid");
}

#[test]
fn pictures_that_go_on_take_no_more_memory() {
    let gpu = kit::gpu();
    let scene = island(&gpu, 96);
    let mut live = Live::new(&gpu, renderer(&gpu), scene.clone()).expect("a scene");
    lit(&mut live);
    let film = film(120, 80);
    let target = Image::new(&gpu, "target", [120, 80]).expect("an image");
    let mut view = view(&live, scene.camera, film, 1, Detail::Swift);
    live.draw(&view, &target).expect("a picture");
    let used = gpu.memory().used;
    for step in 0..4 {
        view.camera.eye += Vec3::new(50.0, 10.0 * step as f32, 0.0);
        live.draw(&view, &target).expect("a picture");
        live.ground_changed().expect("bounds");
        live.relight(Duration::ZERO).expect("light");
        assert_eq!(gpu.memory().used, used);
    }
}

#[test]
fn pictures_grow_from_the_top_and_may_be_given_up() {
    let gpu = kit::gpu();
    let scene = island(&gpu, 96);
    let mut live = Live::new(&gpu, renderer(&gpu), scene.clone()).expect("a scene");
    lit(&mut live);
    let film = film(120, 80);
    let whole = view(&live, scene.camera, film, 1, Detail::Full);
    let expected = draw(&gpu, &mut live, &whole);
    let target = Image::<Rgba8>::new(&gpu, "target", [120, 80]).expect("an image");
    live.begin(&whole, &target).expect("begun");
    // First it is found what is seen.
    let part = loop {
        assert!(live.step(Duration::ZERO).expect("a step"));
        let part = texels(&gpu, &target);
        if part[0] != [0; 4] {
            break part;
        }
    };
    assert!(part[..120 * 8] == expected[..120 * 8], "the first rows are there");
    assert!(part[120 * 40..].iter().all(|pixel| *pixel == [0; 4]), "the last ones are not");
    // Another one, and all of it.
    live.begin(&whole, &target).expect("begun");
    while live.step(Duration::ZERO).expect("a step") {}
    assert!(texels(&gpu, &target) == expected);
    assert!(!live.step(Duration::MAX).expect("no step"));
    let small = Image::<Rgba8>::new(&gpu, "target", [60, 80]).expect("an image");
    assert!(live.begin(&whole, &small).is_err(), "a target of another size");
}

#[test]
fn false_colours_are_those_of_the_legend() {
    let gpu = kit::gpu();
    let grid = Grid { cells: 65, extent: 640.0 };
    let mut scene = sandbox(&gpu, grid, |_, _| 0.0);
    scene.camera = Camera { view: straight_down(400.0), fov: 0.8 };
    let mut live = Live::new(&gpu, renderer(&gpu), scene.clone()).expect("a scene");
    lit(&mut live);
    // A layer that rises to the east, by powers of ten.
    let exponent = |x: f32| 4.0 * (x / grid.extent + 0.5) - 2.0;
    let values: Vec<f32> = (0..65 * 65).map(|at| exponent(grid.position(at % 65, 0)[0])).collect();
    let powers: Vec<f32> = values.iter().map(|value| 10_f32.powf(*value)).collect();
    let [linear, powers] = [values, powers].map(|values| stage::upload(&gpu, "layer", &values));
    let film = film(160, 90);
    let plain = view(&live, scene.camera, film, 1, Detail::Swift);
    let under = draw(&gpu, &mut live, &plain);
    for (image, bounds, scale, tolerance) in
        [(linear, [-1.0, 1.0], Scale::Linear, 2), (powers, [0.1, 10.0], Scale::Logarithmic, 4)]
    {
        let shown = Shown::Values { image, bounds, scale };
        let with =
            |opacity| View { overlay: Some(Overlay { shown: shown.clone(), opacity }), ..plain.clone() };
        assert!(draw(&gpu, &mut live, &with(0.0)) == under);
        let [half, whole] = [0.5, 1.0].map(|opacity| draw(&gpu, &mut live, &with(opacity)));
        for row in [3, 45, 80] {
            for column in 0..160 {
                let at = row * 160 + column;
                let ray = plain.camera.ray((column as f32 + 0.5) / 160.0, (row as f32 + 0.5) / 90.0);
                let x = -400.0 * ray.x / ray.y;
                let value = if scale == Scale::Linear { exponent(x) } else { 10_f32.powf(exponent(x)) };
                let expected = shown.colour(value);
                for channel in 0..3 {
                    assert!(
                        whole[at][channel].abs_diff(expected[channel]) <= tolerance,
                        "{scale:?}, column {column}: {:?} in place of {expected:?}",
                        whole[at]
                    );
                    let mean = (u16::from(under[at][channel]) + u16::from(whole[at][channel])) as f32 / 2.0;
                    assert!((f32::from(half[at][channel]) - mean).abs() <= 1.0);
                }
            }
        }
    }
    assert_eq!(overlay_colour(0.0), COLOURS[0]);
    assert_eq!(overlay_colour(1.0), COLOURS[9]);
    assert_eq!(overlay_colour(f32::NAN), COLOURS[0]);

    // Materials: what they are mixed of.
    let weights = Image::<Rgba32f>::new(&gpu, "weights", [65; 2]).expect("an image");
    for (index, (name, colour)) in MATERIALS.iter().enumerate() {
        let mut one = [0.0; 4];
        one[index] = 1.0;
        let mut rec = Recorder::new(&gpu);
        rec.upload(&weights, &vec![one; 65 * 65]);
        rec.submit().expect("submitted").wait().expect("finished");
        let shown = Shown::Materials(weights.clone());
        let view = View { overlay: Some(Overlay { shown, opacity: 1.0 }), ..plain.clone() };
        let found = draw(&gpu, &mut live, &view)[160 * 45 + 80];
        assert_eq!(found[..3], colour[..], "{name}");
    }
}

#[test]
fn only_land_and_water_take_false_colours() {
    let gpu = kit::gpu();
    let scene = island(&gpu, 96);
    let mut live = Live::new(&gpu, renderer(&gpu), scene.clone()).expect("a scene");
    lit(&mut live);
    let film = film(160, 90);
    let plain = view(&live, scene.camera, film, 2, Detail::Swift);
    let under = draw(&gpu, &mut live, &plain);
    let image: Image<R32f> = stage::upload(&gpu, "layer", &vec![1.0; 96 * 96]);
    let shown = Shown::Values { image, bounds: [0.0, 1.0], scale: Scale::Linear };
    let overlaid = View { overlay: Some(Overlay { shown, opacity: 1.0 }), ..plain.clone() };
    let found = draw(&gpu, &mut live, &overlaid);
    // The sky, and the sea beyond the grid, are as they were; the middle of the island is not.
    assert!(found[..160 * 5] == under[..160 * 5]);
    assert_eq!(found[160 * 45 + 80][..3], COLOURS[9][..]);
}

#[test]
fn slope_and_materials_can_be_looked_at() {
    let gpu = kit::gpu();
    let grid = Grid { cells: 65, extent: 640.0 };
    let scene = sandbox(&gpu, grid, |x, _| 0.5 * x);
    let live = Live::new(&gpu, renderer(&gpu), scene).expect("a scene");
    let maps = live.maps().expect("maps");
    let mut rec = Recorder::new(&gpu);
    let download = rec.download(&maps.slope);
    let slope = download.take(&rec.submit().expect("submitted").wait().expect("finished"));
    assert!(slope.iter().all(|slope| (slope - 0.5_f32.atan().to_degrees()).abs() < 1e-3));
    assert_eq!(maps.splat.size(), [65; 2]);
}
