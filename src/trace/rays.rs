//! How rays find what they meet: through our own trees, or through the structures of a device that traces rays by itself.

use super::Paths;
use super::tree::{Tree, Way};
use crate::gpu::{self, Buffer, Compute, DeviceKind, Gpu, Image, Recorder, format::R32f};
use crate::shaders::Turn;
use crate::shaders::trace::{connect, connect_query, extend, extend_query};
use std::mem::offset_of;

/// What rays go through.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Traversal {
    /// The device's own acceleration structures (`VK_KHR_ray_query`).
    Query,
    /// Our own wide trees, on any device.
    Bvh,
}

impl Traversal {
    /// The device's own where it has any, and is no CPU: there these are programs too, and lavapipe's take twelve times as long
    /// as ours.
    pub fn best(gpu: &Gpu) -> Self {
        let info = gpu.info();
        if info.ray_query && info.kind != DeviceKind::Cpu { Traversal::Query } else { Traversal::Bvh }
    }

    /// # Errors
    /// The device can't do it: the message says what to do.
    pub fn check(self, gpu: &Gpu) -> gpu::Result<()> {
        let info = gpu.info();
        if self == Traversal::Bvh || info.ray_query {
            return Ok(());
        }
        Err(gpu::Error::NoDevice(format!(
            "{} ({}) traces no rays by itself (VK_KHR_ray_query); leave --traversal out, or choose another device: \
             `terrane devices` says which do",
            info.name, info.driver
        )))
    }
}

/// The programs that send rays, of one traversal.
pub(super) enum Programs {
    Query { extend: Compute<extend_query::Shader>, connect: Compute<connect_query::Shader> },
    Bvh { extend: Compute<extend::Shader>, connect: Compute<connect::Shader> },
}

impl Programs {
    pub fn new(gpu: &Gpu, traversal: Traversal) -> gpu::Result<Self> {
        traversal.check(gpu)?;
        Ok(match traversal {
            Traversal::Query => {
                Programs::Query { extend: Compute::new(gpu, ())?, connect: Compute::new(gpu, ())? }
            }
            Traversal::Bvh => {
                Programs::Bvh { extend: Compute::new(gpu, ())?, connect: Compute::new(gpu, ())? }
            }
        })
    }

    pub fn traversal(&self) -> Traversal {
        match self {
            Programs::Query { .. } => Traversal::Query,
            Programs::Bvh { .. } => Traversal::Bvh,
        }
    }

    /// Finds what the paths in `queue` meet in this turn, among what is in the tree and on the land of these heights. The tree
    /// is of the same traversal.
    pub fn extend(
        &self,
        rec: &mut Recorder,
        push: extend::Push,
        (tree, height): (&Tree, &Image<R32f>),
        paths: &Paths,
        queue: &Buffer<u32>,
    ) {
        let Paths { paths, hits, escaped, land, models, sea, turns, .. } = paths;
        let waiting = (turns, push.turn as usize * size_of::<Turn>() + offset_of!(Turn, paths.groups));
        let Tree { triangles, placements, .. } = tree;
        match (self, &tree.way) {
            (Programs::Bvh { extend, .. }, Way::Bvh(nodes)) => rec.dispatch_indirect(
                extend,
                waiting,
                push,
                extend::Bindings {
                    nodes,
                    triangles,
                    placements,
                    turns,
                    queue,
                    paths,
                    hits,
                    escaped,
                    land,
                    models,
                    sea,
                    height,
                },
            ),
            (Programs::Query { extend, .. }, Way::Query(world)) => {
                let extend::Push { turn, sea_level, lattice } = push;
                rec.dispatch_indirect(
                    extend,
                    waiting,
                    extend_query::Push { turn, sea_level, lattice },
                    extend_query::Bindings {
                        world,
                        placements,
                        turns,
                        queue,
                        paths,
                        hits,
                        escaped,
                        land,
                        models,
                        sea,
                    },
                );
            }
            // There are no others: a tree is made for its tracer.
            _ => {}
        }
    }

    /// Adds the lights that nothing hides from the paths of this turn.
    pub fn connect(
        &self,
        rec: &mut Recorder,
        push: connect::Push,
        (tree, height): (&Tree, &Image<R32f>),
        paths: &Paths,
    ) {
        let Paths { paths, turns, looks, .. } = paths;
        let waiting = (turns, push.turn as usize * size_of::<Turn>() + offset_of!(Turn, looks.groups));
        let Tree { triangles, placements, .. } = tree;
        match (self, &tree.way) {
            (Programs::Bvh { connect, .. }, Way::Bvh(nodes)) => {
                let bindings =
                    connect::Bindings { nodes, triangles, placements, turns, looks, paths, height };
                rec.dispatch_indirect(connect, waiting, push, bindings);
            }
            (Programs::Query { connect, .. }, Way::Query(world)) => {
                let bindings = connect_query::Bindings { world, placements, turns, looks, paths };
                let connect::Push { turn, lattice } = push;
                rec.dispatch_indirect(connect, waiting, connect_query::Push { turn, lattice }, bindings);
            }
            _ => {}
        }
    }
}
