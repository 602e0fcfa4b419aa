//! Draws the user interface: what egui makes of it, triangles in clipped meshes.

use crate::gpu::{
    self, Blend, Buffer, Cull, Depth, Gpu, Image, IndexedDraw, Load, Raster, RasterState, Recorder, Targets,
    Topology,
    format::{Format, Rgba8},
};
use crate::shaders::{PanelVertex, viewer::panel};
use egui::epaint::{ClippedPrimitive, ImageData, ImageDelta, Primitive, Vertex, textures::TexturesDelta};
use egui::{ColorImage, Rect, TextureId};
use std::collections::HashMap;
use std::mem::offset_of;

/// Draws the user interface.
pub struct Painter {
    gpu: Gpu,
    pass: Raster<panel::Shader>,
    textures: HashMap<TextureId, Texture>,
    /// Used in turn, so that none is written while a picture on its way reads it.
    meshes: [Mesh; 3],
    turn: usize,
}

/// A texture of egui's, with the texels that it was uploaded from; parts of it are changed there.
struct Texture {
    image: Image<Rgba8>,
    texels: ColorImage,
    changed: bool,
}

/// Room for the triangles of one picture.
#[derive(Default)]
struct Mesh {
    vertices: Option<Buffer<PanelVertex>>,
    indices: Option<Buffer<u32>>,
}

// A vertex of egui's is uploaded as it is.
const _: () = assert!(
    size_of::<Vertex>() == size_of::<PanelVertex>()
        && offset_of!(Vertex, pos) == offset_of!(PanelVertex, position)
        && offset_of!(Vertex, uv) == offset_of!(PanelVertex, uv)
        && offset_of!(Vertex, color) == offset_of!(PanelVertex, colour)
);

const STATE: RasterState = RasterState {
    color: &[Rgba8::VK],
    depth: Depth::None,
    topology: Topology::Triangles,
    cull: Cull::None,
    blend: Blend::Premultiplied,
};

impl Painter {
    /// # Errors
    /// What the device lacks.
    pub fn new(gpu: &Gpu) -> gpu::Result<Painter> {
        Ok(Painter {
            gpu: gpu.clone(),
            pass: Raster::new(gpu, (), &STATE)?,
            textures: HashMap::new(),
            meshes: Default::default(),
            turn: 0,
        })
    }

    /// Makes the program anew: it has been replaced.
    ///
    /// # Errors
    /// What the device lacks.
    #[cfg(feature = "reload")]
    pub fn reprogram(&mut self) -> gpu::Result<()> {
        self.pass = Raster::new(&self.gpu, (), &STATE)?;
        Ok(())
    }

    /// Takes over what has changed of egui's textures, before the picture that shows them is painted.
    ///
    /// # Errors
    /// No memory.
    pub fn update(&mut self, changes: &TexturesDelta) -> gpu::Result<()> {
        for (id, deltas) in &changes.set {
            for delta in deltas {
                self.change(*id, delta)?;
            }
        }
        Ok(())
    }

    /// What was painted last has been submitted, with all changes of textures.
    pub fn painted(&mut self) {
        self.textures.values_mut().for_each(|texture| texture.changed = false);
    }

    /// Lets go of textures that no picture shows any more.
    pub fn free(&mut self, changes: &TexturesDelta) {
        changes.free.iter().for_each(|id| drop(self.textures.remove(id)));
    }

    fn change(&mut self, id: TextureId, delta: &ImageDelta) -> gpu::Result<()> {
        let ImageData::Color(part) = &delta.image;
        match (delta.pos, self.textures.get_mut(&id)) {
            (Some([left, top]), Some(texture)) => {
                let [width, height] = part.size;
                for row in 0..height {
                    let start = (top + row) * texture.texels.size[0] + left;
                    let target = texture.texels.pixels.get_mut(start..start + width);
                    if let Some(target) = target {
                        target.copy_from_slice(&part.pixels[row * width..(row + 1) * width]);
                    }
                }
                texture.changed = true;
            }
            _ => {
                let size = part.size.map(|side| side as u32);
                let image = Image::new(&self.gpu, "texture", size)?;
                let texture = Texture { image, texels: (**part).clone(), changed: true };
                self.textures.insert(id, texture);
            }
        }
        Ok(())
    }

    /// Paints `primitives` over all of `target`. Textures that are not egui's are looked up in `others`.
    ///
    /// # Errors
    /// No memory.
    pub fn paint(
        &mut self,
        rec: &mut Recorder,
        target: &Image<Rgba8>,
        primitives: &[ClippedPrimitive],
        pixels_per_point: f32,
        others: &HashMap<TextureId, Image<Rgba8>>,
    ) -> gpu::Result<()> {
        for texture in self.textures.values().filter(|texture| texture.changed) {
            rec.upload(&texture.image, bytemuck::cast_slice(&texture.texels.pixels));
        }
        let (mut vertices, mut indices) = (Vec::<Vertex>::new(), Vec::<u32>::new());
        let mut draws = Vec::new();
        for ClippedPrimitive { clip_rect, primitive } in primitives {
            let Primitive::Mesh(mesh) = primitive else { continue };
            let image = self.textures.get(&mesh.texture_id).map(|texture| &texture.image);
            let Some(image) = image.or_else(|| others.get(&mesh.texture_id)) else { continue };
            let first = indices.len() as u32;
            let draw = IndexedDraw {
                indices: first..first + mesh.indices.len() as u32,
                first_vertex: vertices.len() as u32,
                instances: 0..1,
            };
            vertices.extend_from_slice(&mesh.vertices);
            indices.extend_from_slice(&mesh.indices);
            draws.push((draw, *clip_rect, image));
        }
        self.turn = (self.turn + 1) % self.meshes.len();
        let Mesh { vertices: room, indices: index_room } = &mut self.meshes[self.turn];
        let vertex_buffer = ensure(&self.gpu, "panel vertices", room, vertices.len())?;
        let index_buffer = ensure(&self.gpu, "panel indices", index_room, indices.len())?;
        rec.upload_first(vertex_buffer, bytemuck::cast_slice(&vertices));
        rec.upload_first(index_buffer, &indices);

        let size = target.size();
        let push = panel::Push { size: size.map(|side| side as f32 / pixels_per_point) };
        let targets = Targets { color: &[target], depth: None, load: Load::Clear([0.0, 0.0, 0.0, 1.0]) };
        rec.render(&targets, |pass| {
            for (draw, clip, picture) in &draws {
                let (least, end) = pixels(*clip, pixels_per_point, size);
                pass.clip(least, end);
                let bindings = panel::Bindings { vertices: vertex_buffer, picture };
                pass.draw_indexed(&self.pass, index_buffer, draw, push, bindings);
            }
        });
        Ok(())
    }
}

/// A buffer with room for so many elements.
fn ensure<'a, T: bytemuck::Pod>(
    gpu: &Gpu,
    name: &str,
    room: &'a mut Option<Buffer<T>>,
    len: usize,
) -> gpu::Result<&'a Buffer<T>> {
    if room.as_ref().is_none_or(|buffer| buffer.len() < len) {
        *room = None;
        let buffer = Buffer::new(gpu, name, len.next_power_of_two().max(1 << 14))?;
        return Ok(room.insert(buffer));
    }
    room.as_ref().ok_or_else(|| gpu::Error::Unsupported("room for panels".into()))
}

/// The pixels of a rectangle of points, within `size`.
fn pixels(clip: Rect, pixels_per_point: f32, size: [u32; 2]) -> ([u32; 2], [u32; 2]) {
    let pixel = |point: f32, most: u32| (point * pixels_per_point).round().clamp(0.0, most as f32) as u32;
    let [width, height] = size;
    let least = [pixel(clip.min.x, width), pixel(clip.min.y, height)];
    let end = [pixel(clip.max.x, width), pixel(clip.max.y, height)];
    (least, end)
}
