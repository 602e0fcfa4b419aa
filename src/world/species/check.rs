//! From a species as it is written to one that grows.

use super::keys::{Organ, Outline, Species};
use crate::plants::derive::Steps;
use crate::plants::grammar::{self, Grammar, WarningKind};
use crate::plants::species::{self as plant, Form, Shape};
use crate::plants::turtle::{self, Interpretation};
use crate::scene;
use crate::world::fault::{Complaint, Fault};
use crate::world::kinds::*;
use crate::world::place::{KeyPath, shown};
use std::ops::Range;

/// Something and what is allowed in it and hardly meant, or what is wrong.
pub type Checked<T> = Result<(T, Vec<Fault>), Vec<Fault>>;

/// Checks what `written`, which stands at `place`, says as a whole.
pub fn check(name: &str, written: &Species, place: &KeyPath) -> Checked<plant::Species> {
    let mut check = Check { written, place, faults: Vec::new(), remarks: Vec::new(), forms: 0 };
    let materials = check.materials();
    let form = check.plant();
    let Check { faults, remarks, .. } = check;
    let Some(form) = form.filter(|_| faults.is_empty()) else { return Err(faults) };
    let species = plant::Species {
        name: name.into(),
        form,
        materials,
        variants: written.variants,
        height: written.height,
    };
    Ok((species, remarks))
}

/// L-systems inside each other that a species may have: organs of organs are copied.
const MOST_FORMS: u32 = 256;

struct Check<'a> {
    written: &'a Species,
    place: &'a KeyPath,
    faults: Vec<Fault>,
    remarks: Vec<Fault>,
    forms: u32,
}

impl Check<'_> {
    fn refuse(&mut self, place: KeyPath, complaint: Complaint) {
        let fault = complaint.at(place);
        // An organ that stands in several others is met as often.
        if !self.faults.contains(&fault) {
            self.faults.push(fault);
        }
    }

    fn materials(&mut self) -> Vec<scene::Material> {
        let at = self.place.join("materials");
        let mut materials = Vec::new();
        for (name, material) in &self.written.materials {
            let second = material.second_reflectance.unwrap_or(material.reflectance);
            let brightest = material.reflectance.iter().zip(second).map(|(first, second)| first.max(second));
            if brightest.zip(material.transmittance).any(|(back, through)| back + through > 1.0) {
                let label = "what is scattered back and what is let through are shares of the same light: together at most 1";
                self.refuse(at.join(name).join("transmittance"), Complaint::new("is too much light", label));
            }
            materials.push(scene::Material {
                name: name.clone(),
                reflectance: [material.reflectance, second],
                position_factor: material.position_factor,
                value_factor: material.value_factor,
                transmittance: material.transmittance,
                refractive_index: material.refractive_index,
                roughness: material.roughness,
                relief: material.relief,
                emission: [0.0; 3],
            });
        }
        if materials.is_empty() {
            self.refuse(at, Complaint::new("is empty", "a plant is made of something: name a material"));
        }
        materials
    }

    /// Index of a material; of the first one for a name that there is not.
    fn material(&mut self, name: &str, place: KeyPath) -> usize {
        let names = self.written.materials.iter().map(|(name, _)| name.as_str());
        if let Some(index) = names.clone().position(|known| known == name) {
            return index;
        }
        let allowed = format!("materials: {}", names.clone().collect::<Vec<_>>().join(", "));
        self.refuse(place, guess(format!("can't be \"{}\"", shown(name)), name, names, allowed));
        0
    }

    fn wood(&mut self, name: Option<&String>, place: &KeyPath) -> Option<usize> {
        name.map(|name| self.material(name, place.join("wood")))
    }

    fn leaves(&mut self, names: Option<&Vec<String>>, place: &KeyPath) -> Option<Vec<usize>> {
        let place = place.join("leaves");
        let indices = names?.iter().enumerate().map(|(index, name)| self.material(name, place.join(index)));
        Some(indices.collect())
    }

    /// The plant itself.
    fn plant(&mut self) -> Option<Form> {
        let written = self.written;
        let wood = self.wood(written.wood.as_ref(), self.place).unwrap_or(0);
        let leaves = self.leaves(written.leaves.as_ref(), self.place);
        let others: Vec<usize> = (1..written.materials.len()).collect();
        let leaves = leaves.unwrap_or(if others.is_empty() { vec![0] } else { others });
        let turtle = Interpretation {
            angle: written.angle,
            pitch: written.pitch,
            roll: written.roll,
            draw: written.draw.clone(),
            moves: written.r#move.clone(),
            silent: written.silent.clone(),
            plus: written.plus,
            width: written.width,
            taper: written.taper,
            tropism: written.tropism.as_ref().map(|tropism| turtle::Tropism {
                direction: tropism.direction.into(),
                strength: tropism.strength,
            }),
        };
        let place = self.place.clone();
        // Organs that nothing places are wrong all the same when they are.
        let mut organs = Vec::new();
        for (name, organ) in &written.organs {
            let turtle = Interpretation { tropism: None, ..turtle.clone() };
            let outer = Outer { turtle, wood, leaves: leaves.clone(), inside: Vec::new() };
            organs.extend(self.organ(name, organ, &outer));
        }
        let outer = Outer { turtle: turtle.clone(), wood, leaves, inside: Vec::new() };
        self.form(&written.grammar, written.steps, &place, outer)
    }

    /// An L-system at `place`, with the organs that it places.
    fn form(&mut self, text: &str, steps: Option<u32>, place: &KeyPath, outer: Outer) -> Option<Form> {
        self.forms += 1;
        let at = place.join("grammar");
        if self.forms > MOST_FORMS {
            let label = format!("organs inside organs are copied, and {MOST_FORMS} are the most");
            self.refuse(at, Complaint::new("has too many organs inside each other", label));
            return None;
        }
        let grammar = match Grammar::read(text, &self.written.ignore) {
            Ok(grammar) => grammar,
            Err(errors) => {
                errors.iter().for_each(|error| self.refuse(at.clone(), complaint(error)));
                return None;
            }
        };
        for warning in grammar.warnings() {
            let is_wrong = match warning.kind {
                WarningKind::MissingSymbol => true,
                // Where braces and `~` draw, they are nothing else.
                WarningKind::NoModel | WarningKind::OpenBrace => {
                    let Interpretation { draw, moves, silent, .. } = &outer.turtle;
                    ![draw, moves, silent].iter().any(|symbols| symbols.contains(['{', '}', '~', '@']))
                }
                _ => false,
            };
            let verb = if is_wrong { "can't be right" } else { "may be wrong" };
            let problem = format!("{verb}: {}", warning.problem);
            let remark = Complaint::new(problem, warning.expected.clone()).about_part(warning.span.clone());
            if is_wrong {
                self.refuse(at.clone(), remark);
                continue;
            }
            let remark = remark.at(at.clone());
            if !self.remarks.contains(&remark) {
                self.remarks.push(remark);
            }
        }
        let mut organs = Vec::new();
        for (symbol, span) in placed(text) {
            let name = symbol.to_string();
            let Some((_, organ)) = self.written.organs.iter().find(|(known, _)| *known == name) else {
                let known: Vec<&str> = self.written.organs.iter().map(|(name, _)| name.as_str()).collect();
                let label = match known.is_empty() {
                    true => "there are no `organs`".into(),
                    false => format!("organs: {}", known.join(", ")),
                };
                self.refuse(
                    at.clone(),
                    Complaint::new("places an organ that there is not", label).about_part(span),
                );
                continue;
            };
            if outer.inside.contains(&symbol) {
                let label = format!("`{symbol}` would hold itself");
                self.refuse(
                    at.clone(),
                    Complaint::new("places an organ inside itself", label).about_part(span),
                );
                continue;
            }
            organs.extend(self.organ(&name, organ, &outer));
        }
        let Outer { turtle, wood, leaves, .. } = outer;
        let steps = steps.map_or(Steps::UntilDone, Steps::Fixed);
        Some(Form { grammar, steps, turtle, wood, leaves, organs })
    }

    fn organ(&mut self, name: &str, organ: &Organ, outer: &Outer) -> Option<plant::Organ> {
        let place = self.place.join("organs").join(name);
        let symbol = name.chars().next()?;
        let wood = self.wood(organ.wood.as_ref(), &place).unwrap_or(outer.wood);
        let leaves = self.leaves(organ.leaves.as_ref(), &place).unwrap_or_else(|| outer.leaves.clone());
        let shape = match (organ.polygons.is_empty(), organ.grammar.is_empty()) {
            (true, true) => {
                let label = "its `polygons`, or its `grammar`";
                self.refuse(place, Complaint::new("is empty", label).about_key());
                return None;
            }
            (false, false) => {
                let label = "an organ has either polygons or a grammar";
                self.refuse(
                    place.join("grammar"),
                    Complaint::new("can't stand beside `polygons`", label).about_key(),
                );
                return None;
            }
            (false, true) => Shape::Polygons(self.outlines(organ, &leaves, &place)),
            (true, false) => {
                let turtle = Interpretation {
                    angle: organ.angle.unwrap_or(outer.turtle.angle),
                    width: organ.width,
                    tropism: None,
                    ..outer.turtle.clone()
                };
                let inside = outer.inside.iter().copied().chain([symbol]).collect();
                let own = Outer { turtle, wood, leaves, inside };
                Shape::Grown(Box::new(self.form(&organ.grammar, organ.steps, &place, own)?))
            }
        };
        Some(plant::Organ { symbol, shape })
    }

    fn outlines(&mut self, organ: &Organ, leaves: &[usize], place: &KeyPath) -> Vec<plant::Outline> {
        let mut outlines = Vec::new();
        for (index, Outline { material, vertices }) in organ.polygons.iter().enumerate() {
            let place = place.join("polygons").join(index);
            if vertices.is_empty() {
                self.refuse(place.join("vertices"), Complaint::new("is missing", "its corners").about_key());
            }
            let material = material.as_ref().map(|name| self.material(name, place.join("material")));
            let material = material.or(leaves.first().copied()).unwrap_or(0);
            outlines.push(plant::Outline { material, vertices: vertices.clone() });
        }
        outlines
    }
}

/// What a form takes from the one that holds it.
#[derive(Clone)]
struct Outer {
    turtle: Interpretation,
    wood: usize,
    leaves: Vec<usize>,
    /// Organs that it is a part of.
    inside: Vec<char>,
}

fn complaint(error: &grammar::Error) -> Complaint {
    let problem = format!("can't be read: {}", error.problem);
    Complaint::new(problem, error.expected.clone()).about_part(error.span.clone())
}

/// The symbols behind `~` and `@` with their place in the text, each once.
fn placed(grammar: &str) -> Vec<(char, Range<usize>)> {
    let mut found: Vec<(char, Range<usize>)> = Vec::new();
    let mut at = 0;
    for line in grammar.split_inclusive('\n') {
        let code = line.split('#').next().unwrap_or_default();
        for (index, _) in code.match_indices(['~', '@']) {
            let Some(symbol) = code[index + 1..].chars().next() else { continue };
            if !symbol.is_whitespace() && found.iter().all(|(known, _)| *known != symbol) {
                let start = at + index;
                found.push((symbol, start..start + 1 + symbol.len_utf8()));
            }
        }
        at += line.len();
    }
    found
}
