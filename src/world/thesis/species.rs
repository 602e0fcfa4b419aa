//! Trees and plants of the folder as species of a world file.

use super::document::material;
use super::files::{Honda, LSystem, Substance};
use super::growth::{self, DRAW, Growth, SILENT};
use super::settings::{Leaf, Materials, Named, Settings, Tree};
use std::collections::{BTreeMap, BTreeSet};
use std::fmt::Write;

/// The species, and their names.
pub struct Species {
    pub text: String,
    pub trees: Vec<String>,
    pub plants: Vec<String>,
    /// Files by the keys that were made from them.
    pub origins: BTreeMap<String, String>,
}

pub fn write(settings: &Settings) -> Species {
    let (names, text, origins) = (BTreeSet::new(), String::new(), BTreeMap::new());
    let mut writer = Writer { materials: &settings.materials, names, text, origins };
    let trees = settings.trees.iter().map(|tree| writer.tree(tree, &settings.leafs)).collect();
    let plants = settings.plants.iter().map(|plant| writer.plant(plant)).collect();
    Species { text: writer.text, trees, plants, origins: writer.origins }
}

struct Writer<'a> {
    materials: &'a Materials,
    names: BTreeSet<String>,
    text: String,
    origins: BTreeMap<String, String>,
}

/// A leaf of a tree with the symbol of its organ.
type Borne<'a> = (char, &'a Named<Leaf>);

impl Writer<'_> {
    fn tree(&mut self, tree: &Named<Tree>, leafs: &[Named<Leaf>]) -> String {
        match &tree.says {
            Tree::Honda(honda) => {
                let leafs: Vec<Borne> = Honda::free_symbols().zip(leafs).collect();
                let &Honda { height, cone_base_points, material, .. } = honda;
                let growth = honda.growth(&borne(&leafs));
                self.species(&tree.file, &growth, height, cone_base_points, material, &leafs)
            }
            Tree::LSystem(system) => {
                let leafs: Vec<Borne> = system.free_symbols().zip(leafs).collect();
                self.system(&tree.file, system, &leafs)
            }
        }
    }

    fn plant(&mut self, plant: &Named<LSystem>) -> String {
        self.system(&plant.file, &plant.says, &[])
    }

    fn system(&mut self, file: &str, system: &LSystem, leafs: &[Borne]) -> String {
        let growth = system.growth(&borne(leafs));
        self.species(file, &growth, system.height, system.cone_base_points, system.material, leafs)
    }

    /// Writes a species; its name.
    fn species(
        &mut self,
        file: &str,
        growth: &Growth,
        height: f64,
        sides: f64,
        substance: Substance,
        leafs: &[Borne],
    ) -> String {
        let name = self.name(file);
        self.origins.insert(format!("species.{name}"), file.into());
        let Growth { grammar, steps, width, .. } = growth;
        let wood = substance.name();
        let _ = write!(
            self.text,
            "\n# {file}; ConeBasePoints {sides}: branches have as many sides as they need.\n\
             [species.{name}]\n\
             steps = {steps}\n\
             draw = \"{DRAW}\"\n\
             move = \"\"\n\
             silent = \"{SILENT}\"\n\
             plus = \"right\"\n\
             width = {width}\n\
             height = {height}\n\
             wood = \"{wood}\"\n\
             leaves = [\"{wood}\"]\n\
             grammar = '''\n{grammar}'''\n"
        );
        let mut substances = vec![substance];
        for (_, leaf) in leafs {
            if !substances.contains(&leaf.says.material) {
                substances.push(leaf.says.material);
            }
        }
        for substance in substances {
            let keys = material(self.materials.of(substance));
            let _ = write!(self.text, "\n[species.{name}.materials.{}]\n{keys}", substance.name());
        }
        for (symbol, leaf) in leafs {
            self.origins.insert(format!("species.{name}.organs.{symbol}"), leaf.file.clone());
            let Leaf { growth: Growth { grammar, steps, width, angle }, material, .. } = &leaf.says;
            let material = material.name();
            let _ = write!(
                self.text,
                "\n# {}\n\
                 [species.{name}.organs.{symbol}]\n\
                 steps = {steps}\n\
                 angle = {angle}\n\
                 width = {width}\n\
                 wood = \"{material}\"\n\
                 leaves = [\"{material}\"]\n\
                 grammar = '''\n{grammar}'''\n",
                leaf.file
            );
        }
        name
    }

    /// A name for what a file describes, of the letters that names have.
    fn name(&mut self, file: &str) -> String {
        let allowed = |letter: char| letter.is_ascii_alphanumeric() || letter == '-';
        let plain: String = file.chars().map(|letter| if allowed(letter) { letter } else { '_' }).collect();
        let others = (2..).map(|number| format!("{plain}_{number}"));
        let name = std::iter::once(plain.clone()).chain(others).find(|name| !self.names.contains(name));
        let name = name.unwrap_or(plain);
        self.names.insert(name.clone());
        name
    }
}

fn borne(leafs: &[Borne]) -> Vec<growth::Leaf> {
    leafs.iter().map(|(symbol, leaf)| growth::Leaf { symbol: *symbol, scale: leaf.says.scale }).collect()
}
