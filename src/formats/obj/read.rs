//! Reading OBJ of any make, with the materials that it names. A line that makes no sense is an error and never a panic, and
//! memory is counted before it is taken, which the crates for this format don't do.

use crate::core::mesh::Mesh;
use crate::formats::model::{
    Budget, Import, Parts, beside, check_finite, grey, smooth, stem, unit, unsuitable,
};
use crate::formats::{Error, png};
use crate::scene::Material;
use std::borrow::Cow;
use std::collections::HashMap;
use std::path::Path;
use std::str::SplitAsciiWhitespace;

/// Most pixels of all textures of a file together.
const MOST_PIXELS: u64 = 1 << 28;

/// Reads a file as one model with a part for each material.
///
/// # Errors
/// When it can't be read, is damaged or too large, or has no faces.
pub fn read(path: &Path) -> Result<Import, Error> {
    let mut budget = Budget::new(path);
    let bytes = budget.bytes(path)?;
    let mut reader = Reader {
        path,
        budget,
        positions: Vec::new(),
        normals: Vec::new(),
        uvs: Vec::new(),
        materials: HashMap::new(),
        current: String::new(),
        groups: Vec::new(),
        by_name: HashMap::new(),
        warnings: Vec::new(),
        pixels: MOST_PIXELS,
    };
    let mut rest = &bytes[..];
    let mut number = 0;
    while !rest.is_empty() {
        let (length, lines) = statement(rest);
        let (line, after) = rest.split_at(length);
        let line = String::from_utf8_lossy(line);
        let joined = if line.contains('\\') { join(&line).into() } else { line };
        reader.line(&joined).map_err(|problem| match problem {
            Problem::Line(reason) => corrupt(path, number, reason),
            Problem::File(error) => error,
        })?;
        rest = after;
        number += lines;
    }
    reader.finish()
}

/// How many bytes the first statement of a text has, and lines: a `\` at the end of one joins the next to it. Comments end
/// with their line; a path may stand in one.
fn statement(text: &[u8]) -> (usize, usize) {
    let (mut length, mut lines) = (0, 0);
    for line in text.split_inclusive(|byte| *byte == b'\n') {
        length += line.len();
        lines += 1;
        if !line.trim_ascii_end().ends_with(b"\\") || line.contains(&b'#') {
            break;
        }
    }
    (length, lines)
}

/// The lines of a statement as one.
fn join(lines: &str) -> String {
    let parts = lines.lines().map(|line| line.trim_end().trim_end_matches('\\'));
    parts.collect::<Vec<_>>().join(" ")
}

/// What a line has done wrong.
enum Problem {
    Line(&'static str),
    File(Error),
}

impl From<Error> for Problem {
    fn from(error: Error) -> Self {
        Problem::File(error)
    }
}

struct Reader<'a> {
    path: &'a Path,
    budget: Budget<'a>,
    positions: Vec<[f32; 3]>,
    normals: Vec<[f32; 3]>,
    uvs: Vec<[f32; 2]>,
    /// Of the libraries so far, by name.
    materials: HashMap<String, Material>,
    /// Name of the material of the faces that follow.
    current: String,
    groups: Vec<Group>,
    /// Indices of the groups, by the names of their materials.
    by_name: HashMap<String, usize>,
    warnings: Vec<String>,
    /// How many may still be looked at.
    pixels: u64,
}

/// What the lists of a group take when there is one element in each, bytes.
const FIRST_ELEMENTS: usize = 512;

/// The faces of a material.
struct Group {
    material: String,
    mesh: Mesh,
    vertices: HashMap<Corner, u32>,
    /// Whether every corner has a normal.
    normals: bool,
}

/// Indices of a position, and of texture coordinates and a normal if there are any.
type Corner = (u32, Option<u32>, Option<u32>);

impl Reader<'_> {
    fn line(&mut self, line: &str) -> Result<(), Problem> {
        let line = line.split('#').next().unwrap_or_default().trim();
        let mut words = line.split_ascii_whitespace();
        let Some(keyword) = words.next() else { return Ok(()) };
        let rest = line[keyword.len()..].trim();
        match keyword {
            "v" => push(&mut self.budget, &mut self.positions, numbers(words)?)?,
            "vn" => push(&mut self.budget, &mut self.normals, numbers(words)?)?,
            "vt" => {
                // The second may be missing.
                let mut words = words.chain(["0"]);
                let uv: [f32; 2] = numbers(words.by_ref())?;
                push(&mut self.budget, &mut self.uvs, [uv[0], 1.0 - uv[1]])?;
            }
            "f" => self.face(words)?,
            "usemtl" => rest.clone_into(&mut self.current),
            "mtllib" => self.library(rest)?,
            // Names, groups, smoothing, lines, points and curves.
            _ => {}
        }
        Ok(())
    }

    /// A polygon as a fan of triangles.
    fn face(&mut self, words: SplitAsciiWhitespace) -> Result<(), Problem> {
        let group = self.group()?;
        let (mut first, mut previous, mut count) = (0, 0, 0);
        for word in words {
            let corner = self.corner(word)?;
            let vertex = self.vertex(group, corner)?;
            if count >= 2 {
                push(&mut self.budget, &mut self.groups[group].mesh.triangles, [first, previous, vertex])?;
            }
            if count == 0 {
                first = vertex;
            }
            previous = vertex;
            count += 1;
        }
        if count < 3 { Err(Problem::Line("a face has less than three corners")) } else { Ok(()) }
    }

    /// The group of the material in force.
    fn group(&mut self) -> Result<usize, Problem> {
        if let Some(group) = self.by_name.get(&self.current) {
            return Ok(*group);
        }
        // Twice as long as they double, and the first few elements of each of their lists.
        self.budget.take((2 * (size_of::<Group>() + self.current.len()) + FIRST_ELEMENTS) as u64)?;
        self.by_name.insert(self.current.clone(), self.groups.len());
        let group = Group {
            material: self.current.clone(),
            mesh: Mesh::default(),
            vertices: HashMap::new(),
            normals: true,
        };
        self.groups.push(group);
        Ok(self.groups.len() - 1)
    }

    /// Reads `7`, `7/2`, `7//3` or `7/2/3`, counted from 1, or from the last one back.
    fn corner(&self, word: &str) -> Result<Corner, Problem> {
        let mut words = word.split('/');
        let mut index = |count: usize| match words.next() {
            None | Some("") => Ok(None),
            Some(word) => {
                let number: i64 = word.parse().map_err(|_| Problem::Line("a corner is no number"))?;
                let index = if number < 0 { count as i64 + number } else { number - 1 };
                let index = u32::try_from(index).ok().filter(|index| (*index as usize) < count);
                index.map(Some).ok_or(Problem::Line("a face has a corner that is missing"))
            }
        };
        let position = index(self.positions.len())?.ok_or(Problem::Line("a corner has no position"))?;
        Ok((position, index(self.uvs.len())?, index(self.normals.len())?))
    }

    /// The vertex of a group's mesh at a corner.
    fn vertex(&mut self, group: usize, corner: Corner) -> Result<u32, Problem> {
        let Group { mesh, vertices, normals, .. } = &mut self.groups[group];
        if let Some(vertex) = vertices.get(&corner) {
            return Ok(*vertex);
        }
        let (position, uv, normal) = corner;
        let vertex = mesh.positions.len() as u32;
        // The entry, with the room that the table keeps free.
        self.budget.take(2 * size_of::<(Corner, u32)>() as u64)?;
        push(&mut self.budget, &mut mesh.positions, self.positions[position as usize])?;
        push(&mut self.budget, &mut mesh.uvs, uv.map_or([0.0; 2], |uv| self.uvs[uv as usize]))?;
        let direction = normal.map_or([0.0; 3], |normal| unit(self.normals[normal as usize]));
        push(&mut self.budget, &mut mesh.normals, direction)?;
        *normals &= normal.is_some();
        vertices.insert(corner, vertex);
        Ok(vertex)
    }

    /// Reads the materials in a file beside.
    fn library(&mut self, name: &str) -> Result<(), Problem> {
        let shown: String = name.chars().take(100).flat_map(char::escape_debug).collect();
        let Some(path) = beside(self.path, name) else {
            self.warn(format!("names materials outside of its folder, \"{shown}\", which are left out"));
            return Ok(());
        };
        if !path.is_file() {
            self.warn(format!("names materials that are missing, \"{shown}\": its faces are grey"));
            return Ok(());
        }
        let bytes = self.budget.bytes(&path)?;
        let mut material: Option<Material> = None;
        for (number, line) in bytes.split(|byte| *byte == b'\n').enumerate() {
            let line: Cow<str> = String::from_utf8_lossy(line);
            let line = line.split('#').next().unwrap_or_default().trim();
            let mut words = line.split_ascii_whitespace();
            let Some(keyword) = words.next() else { continue };
            let rest = line[keyword.len()..].trim();
            let wrong = |_| corrupt(&path, number, "a number is none");
            match (keyword, &mut material) {
                ("newmtl", _) => {
                    self.keep(material.take())?;
                    material = Some(Material { name: rest.into(), ..grey() });
                }
                ("Kd", Some(material)) if rest.starts_with(|letter: char| !letter.is_ascii_alphabetic()) => {
                    // One number is that of all three.
                    let first: Vec<&str> = words.take(3).collect();
                    let words = first.iter().cycle().take(3).copied();
                    let color = numbers::<3>(words).map_err(wrong)?;
                    material.reflectance = [color.map(|channel| channel.clamp(0.0, 1.0)); 2];
                }
                ("Ni", Some(material)) => {
                    material.refractive_index = numbers::<1>(words).map_err(wrong)?[0].max(1.0);
                }
                ("Pr", Some(material)) => {
                    material.roughness = numbers::<1>(words).map_err(wrong)?[0].clamp(0.0, 1.0);
                }
                ("map_Kd", Some(material)) => {
                    let mean = self.texture(rest)?;
                    for color in &mut material.reflectance {
                        *color = std::array::from_fn(|channel| color[channel] * mean[channel]);
                    }
                }
                _ => {}
            }
        }
        self.keep(material)?;
        self.budget.release(bytes);
        Ok(())
    }

    fn keep(&mut self, material: Option<Material>) -> Result<(), Error> {
        let Some(material) = material else { return Ok(()) };
        self.budget.take(4 * (size_of::<Material>() + material.name.len()) as u64)?;
        self.materials.insert(material.name.clone(), material);
        Ok(())
    }

    /// The mean colour of a picture beside; white, with a warning, where it can't be known.
    fn texture(&mut self, name: &str) -> Result<[f32; 3], Error> {
        let path = beside(self.path, name).filter(|path| path.is_file());
        let bytes = path.map(|path| self.budget.bytes(&path)).transpose()?;
        let color = bytes.as_ref().and_then(|bytes| png::mean_color(bytes, &mut self.pixels));
        if let Some(bytes) = bytes {
            self.budget.release(bytes);
        }
        self.warn(String::from(match color {
            Some(_) => "its textures are not drawn: surfaces have their mean colours",
            None => {
                "it has textures that are not PNG: surfaces have the colours that its materials give beside"
            }
        }));
        Ok(color.unwrap_or([1.0; 3]))
    }

    fn finish(self) -> Result<Import, Error> {
        let Reader { path, materials, groups, mut warnings, .. } = self;
        let mut parts = Parts::default();
        for Group { material, mut mesh, normals, .. } in groups {
            if mesh.triangles.is_empty() {
                continue;
            }
            check_finite(path, &mesh.positions)?;
            check_finite(path, &mesh.uvs)?;
            if !normals {
                smooth(&mut mesh);
            }
            parts.add(path, materials.get(&material).unwrap_or(&grey()), mesh)?;
        }
        if parts.level.parts.is_empty() {
            return Err(unsuitable(path, "it has no faces"));
        }
        warnings.dedup();
        Ok(Import::of_model(parts.into_model(stem(path)), warnings))
    }

    fn warn(&mut self, warning: String) {
        let warning = format!("{}: {warning}", self.path.display());
        if self.warnings.len() < 10 && !self.warnings.contains(&warning) {
            self.warnings.push(warning);
        }
    }
}

/// Adds to a list, whose room doubles when it runs out.
fn push<T>(budget: &mut Budget, list: &mut Vec<T>, element: T) -> Result<(), Problem> {
    budget.take(2 * size_of::<T>() as u64)?;
    list.push(element);
    Ok(())
}

/// The first `N` words as numbers.
fn numbers<'a, const N: usize>(mut words: impl Iterator<Item = &'a str>) -> Result<[f32; N], Problem> {
    let mut numbers = [0.0; N];
    for number in &mut numbers {
        let word = words.next().ok_or(Problem::Line("a number is missing"))?;
        *number = word.parse().map_err(|_| Problem::Line("a number is none"))?;
    }
    Ok(numbers)
}

/// Lines are counted from 1.
fn corrupt(path: &Path, line: usize, reason: &str) -> Error {
    Error::Corrupt { path: path.into(), format: "OBJ", reason: format!("{reason}, in line {}", line + 1) }
}
