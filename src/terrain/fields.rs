//! The state of the land: one texel a sample of the grid, on the GPU from beginning to end.

use super::{Plan, hydraulic::Slope, image_of};
use crate::{
    core::grid::Grid,
    gpu::{
        self, Compute, Gpu, Image, PingPong, Recorder,
        format::{R32f, Rgba32f},
    },
    shaders::terrain::control,
};

/// The images that processes read and change. Those of a process that the world does not have are a single texel.
pub struct Fields {
    pub grid: Grid,
    /// Height of the sea above the datum, m; far below all land where nothing acts as a sea.
    pub sea_level: f32,
    /// Ground above the datum, m: `start + change` at all times, kept to save reads.
    pub height: PingPong<Image<R32f>>,
    /// Ground when the current count of changes began (h0), m.
    pub start: Image<R32f>,
    /// What erosion did since (e), m. In 32 bits a height of some hundred metres cannot hold the change of one step; this
    /// can.
    pub change: Image<R32f>,
    /// Depth of the water d, m; sediment that leaves with each m³/s of outflow in a step c, m, and discharge |v|·d, m²/s,
    /// or, for semi-Lagrangian transport, velocity (x, z), m/s; the water counter, s.
    pub water: PingPong<Image<Rgba32f>>,
    /// Suspended sediment s, m of ground.
    pub sediment: PingPong<Image<R32f>>,
    /// Outflow to L, R, T, B, m³/s.
    pub axis: PingPong<Image<Rgba32f>>,
    /// Outflow to TL, TR, BL, BR, m³/s.
    pub diagonal: PingPong<Image<Rgba32f>>,
    /// tan of the slope that the capacity sees, unless it is the ground's.
    pub slope: Image<R32f>,
    /// Thickness that the reef has gained (or lost as rubble), m.
    pub reef: Image<R32f>,
    /// Inorganic carbon in the water O, 1.
    pub carbon: PingPong<Image<R32f>>,
    /// Factors of rain, erodibility and every change of the ground; one is spare.
    pub controls: Image<Rgba32f>,
}

impl Fields {
    /// # Errors
    /// An image that does not fit the device or its memory.
    pub fn new(gpu: &Gpu, plan: &Plan) -> gpu::Result<Fields> {
        let size = |used: bool| if used { [plan.grid.cells; 2] } else { [1, 1] };
        let images = Images::of(plan);
        let fields = Fields {
            grid: plan.grid,
            sea_level: plan.acting_sea_level(),
            height: PingPong::images(gpu, "height", size(true))?,
            start: Image::new(gpu, "start", size(true))?,
            change: Image::new(gpu, "change", size(true))?,
            water: PingPong::images(gpu, "water", size(images.hydraulic))?,
            sediment: PingPong::images(gpu, "sediment", size(images.hydraulic))?,
            axis: PingPong::images(gpu, "axis flow", size(images.hydraulic))?,
            diagonal: PingPong::images(gpu, "diagonal flow", size(images.diagonal))?,
            slope: Image::new(gpu, "slope", size(images.slope))?,
            reef: Image::new(gpu, "reef", size(images.reef))?,
            carbon: PingPong::images(gpu, "carbon", size(images.reef))?,
            controls: Image::new(gpu, "controls", size(images.controls))?,
        };
        fields.fill_controls(gpu, plan)?;
        Ok(fields)
    }

    /// Counts changes from the ground as it is now.
    pub fn rebase(&self, rec: &mut Recorder) {
        rec.copy(self.height.src(), &self.start);
        rec.clear(&self.change);
    }

    /// Fills the controls from the plan's maps; makes their image if there was none.
    pub(super) fn retune_controls(&mut self, gpu: &Gpu, plan: &Plan) -> gpu::Result<()> {
        if plan.controls.any() && self.controls.size() != [self.grid.cells; 2] {
            self.controls = Image::new(gpu, "controls", [self.grid.cells; 2])?;
        }
        self.fill_controls(gpu, plan)
    }

    fn fill_controls(&self, gpu: &Gpu, plan: &Plan) -> gpu::Result<()> {
        if !plan.controls.any() {
            return Ok(());
        }
        let pass = Compute::<control::Shader>::new(gpu, ())?;
        let mut rec = Recorder::new(gpu);
        rec.upload(&self.controls, &vec![[1.0; 4]; self.grid.samples()]);
        for (channel, map) in plan.controls.channels().into_iter().enumerate() {
            let Some(map) = map else { continue };
            let raster = image_of(map, gpu)?;
            rec.upload(&raster, &map.values);
            rec.dispatch(
                &pass,
                self.controls.size(),
                control::Push { channel: channel as u32 },
                control::Bindings { controls: &self.controls, raster: &raster },
            );
        }
        rec.submit()?.wait()?;
        Ok(())
    }
}

/// Which images a plan needs in full.
#[derive(Clone, Copy, PartialEq)]
pub(super) struct Images {
    pub hydraulic: bool,
    pub diagonal: bool,
    pub slope: bool,
    pub reef: bool,
    pub controls: bool,
}

impl Images {
    pub fn of(plan: &Plan) -> Images {
        let hydraulic = plan.hydraulic.as_ref();
        Images {
            hydraulic: hydraulic.is_some(),
            diagonal: hydraulic.is_some_and(|params| params.flows_diagonally()),
            slope: hydraulic.is_some_and(|params| params.slope == Slope::Outflow),
            reef: plan.reef.is_some(),
            controls: plan.controls.any(),
        }
    }
}
