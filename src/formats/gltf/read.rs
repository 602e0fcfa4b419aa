//! Reading models and where they stand from .glb and .gltf files of any make.

use super::accessor::{Numbers, buffers, numbers};
use super::document::{Document, Index, InstanceAttributes, Node, NodeExtras};
use super::shape::Shapes;
use super::transform::Transform;
use super::{PROGRAM, corrupt};
use crate::core::hash::mix;
use crate::formats::Error;
use crate::formats::model::{Budget, Import, unsuitable};
use crate::scene::{Instance, Population};
use glam::{Quat, Vec3};
use serde::Deserialize;
use serde_json::value::RawValue;
use std::ops::Range;
use std::path::Path;

/// Longest JSON that is read, bytes: a hundred thousand nodes take less.
const MOST_JSON: usize = 32 << 20;

/// Extensions that change nothing about shapes and places, or whose part in them is read.
const KNOWN: [&str; 5] = [
    "EXT_mesh_gpu_instancing",
    "KHR_lights_punctual",
    "KHR_mesh_quantization",
    "KHR_texture_transform",
    "MSFT_lod",
];

/// Reads a file: its scene's nodes become instances, and each mesh a model of one level, or of those that
/// [`super::write_model`] wrote. Where a node stretches its mesh there is a stretched copy of it.
///
/// # Errors
/// When it can't be read, is damaged, too large, or needs an extension that is not supported.
pub fn read(path: &Path) -> Result<Import, Error> {
    let mut budget = Budget::new(path);
    let mut bytes = budget.bytes(path)?;
    let (json, binary) = if bytes.starts_with(b"glTF") {
        chunks(&bytes).map_err(|reason| corrupt(path, reason))?
    } else {
        (0..bytes.len(), 0..0)
    };
    let document = parse(path, &bytes[json])?;
    budget.take(document.bytes())?;
    bytes.truncate(binary.end);
    bytes.drain(..binary.start);
    let buffers = buffers(path, &document, bytes, &mut budget)?;

    let shapes = Shapes::new(path, &document, &buffers, budget);
    let mut reader = Reader { path, document: &document, buffers: &buffers, shapes, instances: Vec::new() };
    reader.walk()?;
    let Reader { shapes: Shapes { models, warnings, .. }, instances, .. } = reader;
    if models.is_empty() {
        return Err(unsuitable(path, "its scene has no triangles"));
    }
    let own = document.asset.generator.as_deref().is_some_and(|name| name.starts_with(PROGRAM));
    let is_own_scene = own && instances.len() > 1;
    Ok(Import { population: Population { models, instances: instances.into() }, warnings, is_own_scene })
}

/// What a node or material says in its own words, if those are ours.
pub fn extras<T: for<'a> Deserialize<'a>>(raw: Option<&RawValue>) -> Option<T> {
    serde_json::from_str(raw?.get()).ok()
}

/// Where the JSON and binary chunks of a .glb file lie (§4.4).
fn chunks(bytes: &[u8]) -> Result<(Range<usize>, Range<usize>), String> {
    let cut_off = || String::from("it is cut off");
    let number = |at: usize| {
        let bytes = bytes.get(at..at + 4).and_then(|bytes| bytes.try_into().ok());
        bytes.map(u32::from_le_bytes).ok_or_else(cut_off)
    };
    let version = number(4)?;
    if version != 2 {
        return Err(format!("it is of version {version}, and 2 is read"));
    }
    let chunk = |at: usize, kind: &[u8; 4]| {
        let range = at + 8..at + 8 + number(at)? as usize;
        if bytes.get(at + 4..at + 8) != Some(&kind[..]) {
            return Err(format!("there is no chunk {} where it must be", kind.escape_ascii()));
        }
        if range.end <= bytes.len() { Ok(range) } else { Err(cut_off()) }
    };
    let json = chunk(12, b"JSON")?;
    let binary = if json.end < bytes.len() { chunk(json.end, b"BIN\0")? } else { 0..0 };
    Ok((json, binary))
}

fn parse(path: &Path, json: &[u8]) -> Result<Document, Error> {
    if json.len() > MOST_JSON {
        return Err(corrupt(path, format!("its JSON has {} bytes and may have {MOST_JSON}", json.len())));
    }
    let document: Document =
        serde_json::from_slice(json).map_err(|error| corrupt(path, format!("in its JSON, {error}")))?;
    let version = &document.asset.version;
    if !version.starts_with("2.") {
        return Err(corrupt(path, format!("it is of version \"{}\", and 2 is read", version.escape_debug())));
    }
    let unknown = |name: &&String| !KNOWN.contains(&name.as_str()) && !name.starts_with("KHR_materials_");
    if let Some(name) = document.extensions_required.iter().find(unknown) {
        let name: String = name.escape_debug().take(100).collect();
        return Err(unsuitable(path, format!("it needs the extension {name}; write it again without")));
    }
    Ok(document)
}

/// A walk through the nodes of a scene.
struct Reader<'a> {
    path: &'a Path,
    document: &'a Document,
    buffers: &'a [Vec<u8>],
    shapes: Shapes<'a>,
    instances: Vec<Instance>,
}

impl<'a> Reader<'a> {
    fn walk(&mut self) -> Result<(), Error> {
        let nodes = &self.document.nodes;
        let mut seen = vec![false; nodes.len()];
        // Children go on top, so that nodes come in the order of the file.
        let mut stack: Vec<(Index, Transform)> =
            self.roots()?.into_iter().rev().map(|root| (root, Transform::IDENTITY)).collect();
        while let Some((index, around)) = stack.pop() {
            let Some(node) = nodes.get(index as usize) else {
                return Err(self.corrupt(format!("node {index} is missing")));
            };
            // Every node has one parent: a second visit is a circle or a shared child.
            if std::mem::replace(&mut seen[index as usize], true) {
                return Err(self.corrupt(format!("node {index} hangs from two others, or from itself")));
            }
            let Some(own) = Transform::of_node(node) else {
                return Err(self.corrupt(format!("node {index} stands nowhere")));
            };
            let transform = around.of(own);
            stack.extend(node.children.iter().rev().map(|child| (*child, transform)));
            self.node(node, transform)?;
        }
        Ok(())
    }

    /// The scene's nodes; without a scene, those that hang from no other.
    fn roots(&self) -> Result<Vec<Index>, Error> {
        let Document { scenes, nodes, scene, .. } = self.document;
        match (scenes.get(scene.unwrap_or(0) as usize), scene) {
            (Some(scene), _) => Ok(scene.nodes.clone()),
            (None, Some(_)) => Err(self.corrupt("its scene is missing")),
            (None, None) => {
                let mut hangs = vec![false; nodes.len()];
                for child in nodes.iter().flat_map(|node| &node.children) {
                    if let Some(hangs) = hangs.get_mut(*child as usize) {
                        *hangs = true;
                    }
                }
                Ok((0..nodes.len() as Index).filter(|index| !hangs[*index as usize]).collect())
            }
        }
    }

    /// Places what a node shows.
    fn node(&mut self, node: &Node, transform: Transform) -> Result<(), Error> {
        let extras = extras::<NodeExtras>(node.extras.as_deref());
        if extras.as_ref().is_some_and(|extras| extras.ground) {
            self.shapes.warn("it has land and sea, which are left out: a world has its own");
            return Ok(());
        }
        let Some(model) = self.shapes.of_node(node)? else { return Ok(()) };
        let instancing = node.extensions.as_ref().and_then(|extensions| extensions.instancing.as_ref());
        match instancing {
            Some(instancing) => self.place_many(model, transform, &instancing.attributes),
            None => self.place(model, transform, extras.and_then(|extras| extras.random)),
        }
    }

    fn place_many(
        &mut self,
        model: u32,
        around: Transform,
        attributes: &InstanceAttributes,
    ) -> Result<(), Error> {
        let numbers = |index: Option<Index>, check: fn(Numbers<'a>) -> Result<Numbers<'a>, String>| {
            let of = |index| numbers(self.document, self.buffers, index).and_then(check);
            index.map(of).transpose().map_err(|reason| corrupt(self.path, reason))
        };
        let position = numbers(attributes.translation, Numbers::vectors::<3>)?;
        let rotation = numbers(attributes.rotation, Numbers::vectors::<4>)?;
        let scale = numbers(attributes.scale, Numbers::vectors::<3>)?;
        let random = numbers(attributes.random, Numbers::wholes::<2>)?;
        let counts =
            [&position, &rotation, &scale, &random].map(|numbers| numbers.as_ref().map(|of| of.count));
        let count = counts.into_iter().flatten().next().unwrap_or(0);
        if counts.into_iter().flatten().any(|other| other != count) {
            return Err(self.corrupt("its instances have not as many places as turns or scales"));
        }
        for index in 0..count {
            let own = Transform::new(
                position.as_ref().map_or(Vec3::ZERO, |position| position.vector(index).into()),
                rotation.as_ref().map_or(Quat::IDENTITY, |turn| Quat::from_array(turn.vector(index))),
                scale.as_ref().map_or(Vec3::ONE, |scale| scale.vector(index).into()),
            );
            let Some(own) = own else {
                return Err(self.corrupt(format!("instance {index} stands nowhere")));
            };
            let random =
                random.as_ref().map(|random| random.whole(index)).map(|[low, high]| low | high << 16);
            self.place(model, around.of(own), random)?;
        }
        Ok(())
    }

    /// Places a model, or a copy of it where it is stretched.
    fn place(&mut self, model: u32, transform: Transform, random: Option<u32>) -> Result<(), Error> {
        let random = random.unwrap_or_else(|| mix(self.instances.len() as u32));
        let instance = match transform {
            Transform::Similar { position, rotation, scale } => {
                Instance { model, random, position, rotation, scale }
            }
            Transform::Affine(affine) => {
                let model = self.shapes.stretched(model, affine)?;
                Instance { model, random, position: Vec3::ZERO, rotation: Quat::IDENTITY, scale: 1.0 }
            }
        };
        if !(instance.position.is_finite() && instance.scale.is_finite()) {
            return Err(self.corrupt("something in it stands infinitely far away"));
        }
        self.shapes.budget.instances(1)?;
        self.instances.push(instance);
        Ok(())
    }

    fn corrupt(&self, reason: impl Into<String>) -> Error {
        corrupt(self.path, reason)
    }
}
