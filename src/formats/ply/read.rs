//! Reading PLY of any make, element by element: what the header promises is checked against the length of the file before
//! memory is taken.

use crate::core::color::{linear_from_srgb, srgb8_from_linear};
use crate::core::mesh::Mesh;
use crate::formats::Error;
use crate::formats::model::{Budget, Import, Parts, check_finite, grey, smooth, stem, unit, unsuitable};
use crate::scene::Material;
use ply_rs_bw::parser::{self, Parser};
use ply_rs_bw::ply::{
    BeginList, ElementDef, Encoding, Property, PropertyAccess, PropertyAccessResult, PropertyType, ScalarType,
};
use std::io::Cursor;
use std::path::Path;

/// Longest header that is read, bytes.
const MOST_HEADER: usize = 1 << 16;

/// Most elements of a list, corners of a polygon above all, and longest line of text.
const MOST_CORNERS: usize = 1 << 12;
const LONGEST_LINE: usize = 1 << 16;

/// Most colours that become materials; more are a painting, of which the mean is left.
const MOST_COLORS: usize = 16;

/// Reads a file as one model. Vertex colours are sRGB, and become a material for each colour if there are few, or one of their
/// mean.
///
/// # Errors
/// When it can't be read, is damaged or too large, or has no faces.
pub fn read(path: &Path) -> Result<Import, Error> {
    let corrupt = |reason: String| Error::Corrupt { path: path.into(), format: "PLY", reason };
    let mut budget = Budget::new(path);
    let bytes = budget.bytes(path)?;
    let end = b"end_header";
    let header = &bytes[..bytes.len().min(MOST_HEADER)];
    let end = header.windows(end.len()).position(|word| word == end).map(|at| at + end.len());
    let line_end = end.and_then(|end| Some(end + bytes[end..].iter().position(|byte| *byte == b'\n')? + 1));
    let Some(line_end) = line_end else { return Err(corrupt("its header has no end".into())) };
    let parser = Parser::<Element>::new();
    let header = parser
        .read_header(&mut parser::Reader::new(Cursor::new(&bytes[..line_end])))
        .map_err(|error| corrupt(first_line(&error)))?;

    let mut source = Source { encoding: header.encoding, rest: &bytes[line_end..] };
    let mut content = Content::default();
    for element in header.elements.values() {
        source.check(element).map_err(corrupt)?;
        let name = element.name.as_str();
        content.make_room(name, element.count as u64, &mut budget)?;
        for _ in 0..element.count {
            let read = source.next(&parser, element).map_err(corrupt)?;
            content.add(name, read, &mut budget)?;
        }
    }
    content.into_import(path, budget)
}

/// The bytes behind the header.
struct Source<'a> {
    encoding: Encoding,
    rest: &'a [u8],
}

impl Source<'_> {
    /// Refuses more elements than there are bytes for.
    fn check(&self, element: &ElementDef) -> Result<(), String> {
        let least: usize = match self.encoding {
            // A digit and what parts it from the next.
            Encoding::Ascii => 2 * element.properties.len(),
            _ => element.properties.values().map(|property| least_bytes(&property.data_type)).sum(),
        };
        // The last line may have no end.
        if least == 0 || element.count > (self.rest.len() + 1) / least {
            return Err(format!("its header promises {} elements and it can't hold them", element.count));
        }
        Ok(())
    }

    fn next(&mut self, parser: &Parser<Element>, element: &ElementDef) -> Result<Element, String> {
        let read = match self.encoding {
            Encoding::Ascii => {
                let end = self.rest.iter().position(|byte| *byte == b'\n').unwrap_or(self.rest.len());
                let (line, rest) = self.rest.split_at(end);
                self.rest = rest.get(1..).unwrap_or_default();
                if line.len() > LONGEST_LINE {
                    return Err(format!("a line has more than {LONGEST_LINE} letters"));
                }
                let line = std::str::from_utf8(line).map_err(|_| "it is no text where it should be")?;
                parser.read_ascii_element(line.trim(), element)
            }
            Encoding::BinaryLittleEndian => parser.read_little_endian_element(&mut self.rest, element),
            Encoding::BinaryBigEndian => parser.read_big_endian_element(&mut self.rest, element),
        };
        read.map_err(|error| first_line(&error))
    }
}

/// What is wanted of a vertex or a face.
#[derive(Default)]
struct Element {
    position: [f32; 3],
    normal: Option<[f32; 3]>,
    uv: Option<[f32; 2]>,
    color: Option<[f32; 3]>,
    corners: Option<Vec<u32>>,
}

impl PropertyAccess for Element {
    fn new() -> Self {
        Element::default()
    }

    fn set_property(&mut self, name: &str, property: Property) -> PropertyAccessResult {
        let Some(value) = scalar(&property) else {
            if matches!(name, "vertex_indices" | "vertex_index") {
                let Some(corners) = property.to_u32_list() else {
                    return PropertyAccessResult::UnsupportedType;
                };
                self.corners = Some(corners);
            }
            return PropertyAccessResult::Set;
        };
        // Whole numbers are shares of 255, in sRGB.
        let color = || match property {
            Property::Float(_) | Property::Double(_) => value,
            _ => linear_from_srgb(value / 255.0),
        };
        match name {
            "x" => self.position[0] = value,
            "y" => self.position[1] = value,
            "z" => self.position[2] = value,
            "nx" => self.normal.get_or_insert_default()[0] = value,
            "ny" => self.normal.get_or_insert_default()[1] = value,
            "nz" => self.normal.get_or_insert_default()[2] = value,
            "s" | "u" | "texture_u" => self.uv.get_or_insert_default()[0] = value,
            "t" | "v" | "texture_v" => self.uv.get_or_insert_default()[1] = 1.0 - value,
            "red" | "r" | "diffuse_red" => self.color.get_or_insert_default()[0] = color(),
            "green" | "g" | "diffuse_green" => self.color.get_or_insert_default()[1] = color(),
            "blue" | "b" | "diffuse_blue" => self.color.get_or_insert_default()[2] = color(),
            _ => {}
        }
        PropertyAccessResult::Set
    }

    fn begin_list_char(&mut self, _: &str, count: usize) -> BeginList<'_, i8> {
        begin(count)
    }

    fn begin_list_uchar(&mut self, _: &str, count: usize) -> BeginList<'_, u8> {
        begin(count)
    }

    fn begin_list_short(&mut self, _: &str, count: usize) -> BeginList<'_, i16> {
        begin(count)
    }

    fn begin_list_ushort(&mut self, _: &str, count: usize) -> BeginList<'_, u16> {
        begin(count)
    }

    fn begin_list_int(&mut self, _: &str, count: usize) -> BeginList<'_, i32> {
        begin(count)
    }

    fn begin_list_uint(&mut self, _: &str, count: usize) -> BeginList<'_, u32> {
        begin(count)
    }

    fn begin_list_float(&mut self, _: &str, count: usize) -> BeginList<'_, f32> {
        begin(count)
    }

    fn begin_list_double(&mut self, _: &str, count: usize) -> BeginList<'_, f64> {
        begin(count)
    }
}

/// Refuses a list that is too long before there is room for it.
fn begin<'a, T>(count: usize) -> BeginList<'a, T> {
    if count <= MOST_CORNERS { BeginList::UseSetter } else { BeginList::UnsupportedType }
}

/// What has been read.
#[derive(Default)]
struct Content {
    mesh: Mesh,
    colors: Vec<[f32; 3]>,
    normals: bool,
    colored: bool,
}

impl Content {
    /// Takes memory for the elements that the header promises.
    fn make_room(&mut self, name: &str, count: u64, budget: &mut Budget) -> Result<(), Error> {
        match name {
            "vertex" => {
                self.mesh =
                    Mesh { triangles: std::mem::take(&mut self.mesh.triangles), ..budget.mesh(count, 0)? };
                self.colors = budget.room(count)?;
            }
            "face" => self.mesh.triangles = budget.room(count)?,
            _ => {}
        }
        Ok(())
    }

    fn add(&mut self, name: &str, element: Element, budget: &mut Budget) -> Result<(), Error> {
        let Element { position, normal, uv, color, corners } = element;
        match name {
            "vertex" => {
                self.mesh.positions.push(position);
                self.mesh.normals.push(unit(normal.unwrap_or_default()));
                self.mesh.uvs.push(uv.unwrap_or_default());
                self.colors.push(color.unwrap_or_default());
                self.normals = normal.is_some();
                self.colored = color.is_some();
            }
            "face" => {
                // A polygon is a fan of triangles; there is room for one, and the list doubles for more.
                let corners = corners.unwrap_or_default();
                budget.take(24 * corners.len().saturating_sub(3) as u64)?;
                for pair in corners.windows(2).skip(1) {
                    self.mesh.triangles.push([corners[0], pair[0], pair[1]]);
                }
            }
            _ => {}
        }
        Ok(())
    }

    fn into_import(mut self, path: &Path, mut budget: Budget) -> Result<Import, Error> {
        let corrupt = |reason: String| Error::Corrupt { path: path.into(), format: "PLY", reason };
        let vertices = self.mesh.positions.len();
        let missing = |triangle: &[u32; 3]| triangle.iter().any(|corner| *corner as usize >= vertices);
        if self.mesh.triangles.iter().any(missing) {
            return Err(corrupt("a face has a corner that is missing".into()));
        }
        if self.mesh.triangles.is_empty() {
            return Err(unsuitable(path, "it has no faces; make a mesh of its points first"));
        }
        check_finite(path, &self.mesh.positions)?;
        check_finite(path, &self.mesh.uvs)?;
        if !self.normals {
            smooth(&mut self.mesh);
        }
        let mut parts = Parts::default();
        let groups = if self.colored { self.groups(&mut budget)? } else { None };
        match groups {
            Some(groups) => {
                for (color, triangles) in groups {
                    parts.add(path, &paint(color), budget.part(&self.mesh, triangles)?)?;
                }
            }
            None if self.colored => parts.add(path, &paint(mean(&self.colors)), self.mesh)?,
            None => parts.add(path, &grey(), self.mesh)?,
        }
        Ok(Import::of_model(parts.into_model(stem(path)), Vec::new()))
    }

    /// The triangles of each colour; `None` if there are many, or triangles of several.
    fn groups(&self, budget: &mut Budget) -> Result<Option<Vec<Group>>, Error> {
        let mut groups: Vec<Group> = Vec::new();
        budget.take(24 * self.mesh.triangles.len() as u64)?;
        for triangle in &self.mesh.triangles {
            let [color, second, third] = triangle.map(|corner| self.colors[corner as usize]);
            if color != second || color != third {
                return Ok(None);
            }
            match groups.iter().position(|(other, _)| *other == color) {
                Some(group) => groups[group].1.push(*triangle),
                None if groups.len() == MOST_COLORS => return Ok(None),
                None => groups.push((color, vec![*triangle])),
            }
        }
        Ok(Some(groups))
    }
}

/// Triangles of one colour.
type Group = ([f32; 3], Vec<[u32; 3]>);

fn paint(color: [f32; 3]) -> Material {
    let color = color.map(|channel| if channel.is_finite() { channel.clamp(0.0, 1.0) } else { 0.5 });
    let [red, green, blue] = color.map(|channel| srgb8_from_linear(channel, 0.5));
    Material { name: format!("#{red:02x}{green:02x}{blue:02x}"), reflectance: [color; 2], ..grey() }
}

fn mean(colors: &[[f32; 3]]) -> [f32; 3] {
    std::array::from_fn(|channel| {
        let sum: f64 = colors.iter().map(|color| f64::from(color[channel])).sum();
        (sum / colors.len().max(1) as f64) as f32
    })
}

/// A number; `None` for a list.
fn scalar(property: &Property) -> Option<f32> {
    match *property {
        Property::Char(value) => Some(value.into()),
        Property::UChar(value) => Some(value.into()),
        Property::Short(value) => Some(value.into()),
        Property::UShort(value) => Some(value.into()),
        Property::Int(value) => Some(value as f32),
        Property::UInt(value) => Some(value as f32),
        Property::Float(value) => Some(value),
        Property::Double(value) => Some(value as f32),
        _ => None,
    }
}

/// Bytes that a property takes at least.
fn least_bytes(kind: &PropertyType) -> usize {
    let of = |scalar: &ScalarType| match scalar {
        ScalarType::Char | ScalarType::UChar => 1,
        ScalarType::Short | ScalarType::UShort => 2,
        ScalarType::Int | ScalarType::UInt | ScalarType::Float => 4,
        ScalarType::Double => 8,
    };
    match kind {
        PropertyType::Scalar(scalar) | PropertyType::List(scalar, _) => of(scalar),
    }
}

/// What is wrong, without the text that it is wrong in.
fn first_line(error: &parser::ParseError) -> String {
    error
        .to_string()
        .lines()
        .next()
        .unwrap_or_default()
        .chars()
        .take(200)
        .flat_map(char::escape_debug)
        .collect()
}
