//! The Vulkan layer: transfers, passes, barriers, limits and errors.

use crate::kit;
use crate::kit::field::check_close;
use terrane::{
    gpu::{
        Attachable, Blend, Buffer, Compute, Cull, Depth, Draw, Error, Gpu, Image, Layers, Load, Options,
        PingPong, Raster, RasterState, Recorder, Targets, Topology, devices,
        format::{Format, R32f, Rgba32f},
    },
    shaders::{raster::terrain, terrain::seabed},
};

/// Deterministic values that are all different.
fn ramp(len: usize) -> Vec<f32> {
    (0..len).map(|index| (index as f32 * 0.37).sin() * 100.0).collect()
}

#[test]
fn texels_survive_the_way_there_and_back() {
    let gpu = kit::gpu();
    let image = Image::<R32f>::new(&gpu, "image", [33, 17]).unwrap();
    let layers = Layers::<Rgba32f>::new(&gpu, "layers", [5, 3], 4).unwrap();
    let buffer = Buffer::<[u32; 3]>::new(&gpu, "buffer", 7).unwrap();
    let texels = ramp(33 * 17);
    let stack: Vec<[f32; 4]> = ramp(5 * 3 * 4).iter().map(|x| [*x, x + 1.0, -x, 0.5]).collect();
    let numbers: Vec<[u32; 3]> = (0..7).map(|i| [i, i * i, 1 << i]).collect();

    let mut rec = Recorder::new(&gpu);
    rec.upload(&image, &texels);
    rec.upload(&layers, &stack);
    rec.upload(&buffer, &numbers);
    let downloads = (rec.download(&image), rec.download(&layers), rec.download(&buffer));
    let done = rec.submit().unwrap().wait().unwrap();

    assert_eq!(downloads.0.take(&done), texels);
    assert_eq!(downloads.1.take(&done), stack);
    assert_eq!(downloads.2.take(&done), numbers);
}

#[test]
fn images_and_buffers_are_born_zeroed() {
    let gpu = kit::gpu();
    // Memory that was just written and freed is what the next allocation is likely to get.
    {
        let used = Image::<R32f>::new(&gpu, "used", [64, 64]).unwrap();
        let mut rec = Recorder::new(&gpu);
        rec.upload(&used, &vec![7.0; 64 * 64]);
        rec.submit().unwrap().wait().unwrap();
    }
    let image = Image::<R32f>::new(&gpu, "image", [64, 64]).unwrap();
    let buffer = Buffer::<u32>::new(&gpu, "buffer", 1000).unwrap();
    let mut rec = Recorder::new(&gpu);
    let downloads = (rec.download(&image), rec.download(&buffer));
    let done = rec.submit().unwrap().wait().unwrap();
    assert!(downloads.0.take(&done).iter().all(|texel| *texel == 0.0));
    assert!(downloads.1.take(&done).iter().all(|element| *element == 0));
}

/// Seven passes of the mean of four neighbours, which need each other's results, against f64.
#[test]
fn passes_wait_for_each_other() {
    const SIZE: usize = 40;
    let gpu = kit::gpu();
    let mut field = PingPong::<Image<R32f>>::images(&gpu, "field", [SIZE as u32; 2]).unwrap();
    let smoothing = Smoothing::new(&gpu, [SIZE as u32; 2]);
    let start = ramp(SIZE * SIZE);

    let mut rec = Recorder::timed(&gpu, 16);
    rec.upload(field.src(), &start);
    for _ in 0..7 {
        smoothing.record(&mut rec, &field);
        field.swap();
    }
    let download = rec.download(field.src());
    let done = rec.submit().unwrap().wait().unwrap();
    let got = download.take(&done);

    let mut want: Vec<f64> = start.iter().map(|height| f64::from(*height)).collect();
    for _ in 0..7 {
        let old = want.clone();
        for j in 1..SIZE - 1 {
            for i in 1..SIZE - 1 {
                let at = j * SIZE + i;
                want[at] = (old[at - 1] + old[at + 1] + old[at - SIZE] + old[at + SIZE]) / 4.0;
            }
        }
    }
    // Seven roundings of values up to 100.
    check_close(&got, &want, 7.0 * 100.0 * f64::from(f32::EPSILON)).unwrap();
    let mut wrong = want.clone();
    wrong[SIZE + 1] += 1e-3;
    check_close(&got, &wrong, 7.0 * 100.0 * f64::from(f32::EPSILON)).unwrap_err();

    let names: Vec<&str> = done.timings.iter().map(|timing| timing.name).collect();
    assert_eq!(names.iter().filter(|name| **name == "terrain/seabed").count(), 7);
}

/// A viewer's window and its engine record and submit at once: each gets its own results, and nothing that one is done with is missed by
/// the other. The validation layer crashed in this, now and then, while recorders destroyed what they had recorded from.
#[test]
fn threads_share_a_device() {
    const SIZE: usize = 16;
    const ROUNDS: usize = 300;
    let gpu = kit::gpu();
    let smooth = |first: f32| {
        let start: Vec<f32> = ramp(SIZE * SIZE).iter().map(|height| height + first).collect();
        let mut field = PingPong::<Image<R32f>>::images(&gpu, "field", [SIZE as u32; 2]).unwrap();
        let smoothing = Smoothing::new(&gpu, [SIZE as u32; 2]);
        let mut rec = Recorder::timed(&gpu, 1);
        rec.upload(field.src(), &start);
        smoothing.record(&mut rec, &field);
        field.swap();
        let download = rec.download(field.src());
        let done = rec.submit().unwrap().wait().unwrap();
        download.take(&done)
    };
    let wanted = [0.0, 50.0].map(smooth);
    assert_ne!(wanted[0], wanted[1]);
    std::thread::scope(|threads| {
        for (first, wanted) in [0.0, 50.0].into_iter().zip(&wanted) {
            threads.spawn(move || (0..ROUNDS).for_each(|_| assert_eq!(&smooth(first), wanted)));
        }
    });
}

/// The canary of every other test: synchronization validation sees a barrier that is not there.
#[test]
fn a_removed_barrier_is_caught() {
    let gpu = kit::own_gpu(Options::default());
    let mut field = PingPong::<Image<R32f>>::images(&gpu, "field", [32, 32]).unwrap();
    let smoothing = Smoothing::new(&gpu, [32, 32]);
    let two_passes = |rec: &mut Recorder, field: &mut PingPong<Image<R32f>>| {
        for _ in 0..2 {
            smoothing.record(rec, field);
            field.swap();
        }
    };

    let mut rec = Recorder::new(&gpu);
    two_passes(&mut rec, &mut field);
    rec.submit().unwrap().wait().unwrap();
    assert_eq!(gpu.messages(), Vec::<String>::new());

    let mut rec = Recorder::new(&gpu);
    rec.concurrent(|rec| two_passes(rec, &mut field));
    rec.submit().unwrap().wait().unwrap();
    let messages = gpu.messages();
    assert!(messages.iter().any(|message| message.contains("SYNC-HAZARD")), "{messages:?}");
}

#[test]
fn nothing_is_left_when_a_device_is_closed() {
    let gpu = kit::own_gpu(Options::default());
    {
        let image = Image::<R32f>::new(&gpu, "image", [16, 16]).unwrap();
        let field = PingPong::new(image.clone(), Image::new(&gpu, "other", [16, 16]).unwrap());
        let smoothing = Smoothing::new(&gpu, [16, 16]);
        let mut rec = Recorder::new(&gpu);
        smoothing.record(&mut rec, &field);
        let submission = rec.submit().unwrap();
        // The submission keeps what it names, also when the handles are gone first.
        drop((image, field, smoothing));
        submission.wait().unwrap();
    }
    assert_eq!(gpu.memory().used, 0);
    assert_eq!(gpu.close(), Vec::<String>::new());
}

#[test]
fn memory_is_counted_by_name_and_limited() {
    let gpu = kit::own_gpu(Options { memory_limit: Some(1 << 20), ..Options::default() });
    let small = Image::<R32f>::new(&gpu, "small", [256, 256]).unwrap();
    assert!(gpu.memory().by_name["small"] >= 4 * 256 * 256);
    let Err(error) = Image::<R32f>::new(&gpu, "large", [1024, 1024]) else { panic!("over the limit") };
    assert!(matches!(&error, Error::MemoryLimit { name, .. } if name == "large"), "{error}");
    assert!(error.to_string().contains("of the 1.0 MiB that this run may use"), "{error}");
    drop(small);
    assert_eq!(gpu.memory().used, 0);
}

#[test]
fn errors_of_a_recording_surface_at_submit() {
    let gpu = kit::gpu();
    let image = Image::<R32f>::new(&gpu, "image", [4, 4]).unwrap();
    let mut rec = Recorder::new(&gpu);
    rec.upload(&image, &[1.0; 3]);
    rec.clear(&image);
    let Err(error) = rec.submit() else { panic!("a wrong upload was taken") };
    assert!(error.to_string().contains("3 elements to a place for 16"), "{error}");
}

#[test]
fn drawing_into_what_a_pipeline_was_not_made_for_is_refused() {
    let gpu = kit::gpu();
    let state = RasterState {
        color: &[R32f::VK],
        depth: Depth::None,
        topology: Topology::Patches(4),
        cull: Cull::None,
        blend: Blend::None,
    };
    let pipeline = Raster::<terrain::Shader>::new(&gpu, (), &state).unwrap();
    let frame = Buffer::new(&gpu, "frame", 1).unwrap();
    let patches = Buffer::new(&gpu, "patches", 1).unwrap();
    let one = Image::<R32f>::new(&gpu, "one", [8, 8]).unwrap();
    let four = Image::<Rgba32f>::new(&gpu, "four", [8, 8]).unwrap();
    let small = Image::<R32f>::new(&gpu, "small", [4, 8]).unwrap();
    let draw = |color: &[&dyn Attachable]| {
        let mut rec = Recorder::new(&gpu);
        rec.render(&Targets { color, depth: None, load: Load::Clear([0.0; 4]) }, |draws| {
            let bindings = terrain::Bindings { frame: &frame, height: &one, patches: &patches };
            let push = terrain::Push { scale: [1.0; 2], offset: [0.0; 2] };
            draws.draw(&pipeline, Draw { vertices: 0, instances: 1 }, push, bindings);
        });
        rec.submit().map(|submission| submission.wait().unwrap())
    };
    draw(&[&one]).unwrap();
    let format = draw(&[&four]).unwrap_err().to_string();
    assert!(format.contains("raster/terrain draws into"), "{format}");
    let size = draw(&[&one, &small]).unwrap_err().to_string();
    assert!(size.contains("images of two sizes"), "{size}");
}

#[test]
fn impossible_images_are_refused_with_the_figures() {
    let gpu = kit::gpu();
    let largest = gpu.info().max_image;
    for size in [[0, 4], [4, 0], [largest + 1, 4]] {
        let Err(error) = Image::<R32f>::new(&gpu, "impossible", size) else { panic!("{size:?}") };
        assert!(error.to_string().contains(&format!("1 to {largest}")), "{error}");
    }
}

#[test]
fn devices_are_chosen_by_index_and_by_part_of_the_name() {
    let all = {
        let _turn = kit::turn();
        devices().unwrap()
    };
    let first = &all[0];
    for wanted in [first.index.to_string(), first.name[..4].to_uppercase()] {
        let gpu = kit::own_gpu(Options { device: Some(wanted), ..Options::default() });
        assert_eq!(gpu.info().name, first.name);
    }
    let _turn = kit::turn();
    let error =
        Gpu::new(&Options { device: Some("no such thing".into()), ..Options::default() }).unwrap_err();
    assert!(matches!(error, Error::NoDevice(_)), "{error}");
    assert!(error.to_string().contains(&first.name), "{error}");
}

/// A pass to test with: the mean of four neighbours.
struct Smoothing {
    pass: Compute<seabed::Shader>,
    change: Image<R32f>,
    controls: Image<Rgba32f>,
}

impl Smoothing {
    fn new(gpu: &Gpu, size: [u32; 2]) -> Smoothing {
        Smoothing {
            pass: Compute::new(gpu, seabed::Constants::default()).unwrap(),
            change: Image::new(gpu, "change", size).unwrap(),
            controls: Image::new(gpu, "controls", [1, 1]).unwrap(),
        }
    }

    fn record(&self, rec: &mut Recorder, field: &PingPong<Image<R32f>>) {
        let Smoothing { pass, change, controls } = self;
        rec.dispatch(
            pass,
            field.src().size(),
            seabed::Push { sea_level: f32::MAX },
            seabed::Bindings { height_in: field.src(), height_out: field.dst(), change, controls },
        );
    }
}
