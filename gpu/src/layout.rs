//! The structs that shaders and Rust share, field by field as in `parts/layout.wgsl`.
//!
//! A test compares every size and offset with what naga makes of the WGSL; nothing is kept in step by
//! hand.

use bytemuck::{Pod, Zeroable};
use pfront_core::Pose;
use pfront_shaders::constants::{FRONTS, PADDING, REST_WORDS};

/// Declares a `#[repr(C)]` struct and the table of its fields, for the comparison.
macro_rules! shared {
    ($($(#[$doc:meta])* $name:ident { $($(#[$field_doc:meta])* $field:ident: $type:ty,)* })*) => {
        $(
            $(#[$doc])*
            #[repr(C)]
            #[derive(Clone, Copy, Debug, Pod, Zeroable)]
            pub(crate) struct $name {
                $($(#[$field_doc])* pub(crate) $field: $type,)*
            }
        )*

        /// Name, size, and the name and offset of each field.
        #[cfg(test)]
        pub(crate) const SHARED: &[(&str, usize, &[(&str, usize)])] = &[
            $((
                stringify!($name),
                size_of::<$name>(),
                &[$((stringify!($field), core::mem::offset_of!($name, $field)),)*],
            ),)*
        ];
    };
}

shared! {
    /// A corner of a triangle; triangles lie in leaf order.
    Corner {
        position: [f32; 3],
        vertex: u32,
    }

    /// How one side stands in the frame of the query.
    Placement {
        rows: [[f32; 4]; 3],
        reach: [[f32; 4]; 3],
    }

    /// A question, and the capacities of all lists.
    Query {
        sides: [Placement; 2],
        posed: [u32; 2],
        seeds: [u32; 2],
        front_capacity: u32,
        leaf_capacity: u32,
        hit_capacity: u32,
        kept_capacity: u32,
        rest_capacity: u32,
        leaf_size: u32,
        within: u32,
        apart: u32,
        levels: u32,
        last_pass: u32,
        one_hit: u32,
        beam: u32,
        pair_shift: u32,
        each: u32,
        certify: u32,
        padding: u32,
        error: [f32; 3],
        distance: f32,
        ticket: u32,
        padding_1: u32,
        padding_2: u32,
        padding_3: u32,
    }

    /// An instance, or body.
    Body {
        pose: [[f32; 4]; 3],
        inverse: [[f32; 4]; 3],
        reach: [f32; 3],
        flushed: f32,
        kind: u32,
        first_node: u32,
        first_slot: u32,
        padding: u32,
    }

    /// A block of ids: two bodies, the number of their pair, and the first of its ids.
    Row {
        bodies: [u32; 2],
        number: u32,
        first_id: u32,
    }

    /// A pair of instances: how the second stands in the frame in which boxes are compared, and both in the world.
    InstancePair {
        boxes: [[f32; 4]; 3],
        pad_a: [f32; 3],
        posed_boxes: u32,
        pad_b: [f32; 3],
        number: u32,
        first_id: u32,
        first_node: u32,
        first_slot: u32,
        padding: u32,
        poses: [[[f32; 4]; 3]; 2],
    }

    /// One pass of a run.
    Step {
        pass_index: u32,
        keep_leaves: u32,
    }

    /// The jobs of one stage of a refit.
    Stage {
        first_job: u32,
        end_job: u32,
    }

    /// Where vertices are in a buffer of the caller's, and the box that holds them.
    Taking {
        low: [i32; 3],
        vertices: u32,
        high: [i32; 3],
        stride: u32,
        first: u32,
        padding_1: u32,
        padding_2: u32,
        padding_3: u32,
    }

    /// Parameters of a dispatch of a build.
    Build {
        triangles: u32,
        depth: u32,
        bottom: u32,
        top: u32,
        run: u32,
        workgroups: u32,
        shift: u32,
    }

    /// How to divide the triangles of a node.
    Cut {
        axis: u32,
        low: f32,
        cells: f32,
    }

    /// Counters of a run.
    Counters {
        last_hits: u32,
        last_overflow: u32,
        last_rest: u32,
        ticket: u32,
        leaves: u32,
        hits: u32,
        overflow: u32,
        kept: u32,
        open: u32,
        rest: u32,
        unordered: u32,
        node_pairs: u32,
        fronts: [u32; FRONTS as usize],
        readers: u32,
    }

    /// A triangle pair for the CPU.
    Rest {
        corners: [Corner; 6],
        pair: [u32; 2],
        padding: [u32; 2],
    }

    /// One test of the adapter's arithmetic.
    Trial {
        row: [f32; 4],
        point: [f32; 3],
        doubted: u32,
        found: [f32; 3],
        padding_after: u32,
    }
}

const _: () = assert!(size_of::<Rest>() == 16 * REST_WORDS as usize);

impl Counters {
    pub(crate) fn longest_front(&self) -> u32 {
        self.fronts.iter().fold(0, |longest, &front| longest.max(front))
    }
}

/// The largest coordinate of a mesh that is posed, since shaders subtract and pad coordinates before they pose them.
pub(crate) const LARGEST_POSED: f32 = f32::MAX / 2.0;

/// The largest distance by which boxes grow, so that those of posed coordinates stay finite.
pub(crate) const LARGEST_DISTANCE: f32 = f32::MAX / 4.0;

impl Placement {
    /// A pose as the shaders use it.
    ///
    /// The magnitudes in `reach` pad a box by [`PADDING`] of themselves (`boxes.wgsl`), which covers roundings
    /// of normal numbers only. An adapter may flush an entry below 2^-126; to be covered then too, its
    /// magnitude counts as 2^-107.
    pub(crate) fn new(pose: &Pose) -> Self {
        const FLUSHED: f32 = f32::MIN_POSITIVE * 16.0;
        let magnitude = |x: f32| {
            if x.is_subnormal() { f32::MIN_POSITIVE * (1 << 19) as f32 } else { x.abs() }
        };
        let reach = pose.rows.map(|[x, y, z, t]| {
            let [x, y, z] = [x, y, z].map(magnitude);
            [x, y, z, t.abs() * PADDING + FLUSHED]
        });
        Self { rows: pose.rows, reach }
    }

    /// Has boxes reach so much farther, and what the sums with that distance round.
    pub(crate) fn grow(&mut self, distance: f32) {
        const ROUNDED: f32 = 1.0 + PADDING;
        self.reach.iter_mut().for_each(|[.., w]| *w += distance * ROUNDED);
    }

    /// The pose of a shadow, whose corners may be so far from what they stand for.
    pub(crate) fn of_shadow(pose: &Pose, padding: [f32; 3]) -> Self {
        let mut own = Self::new(pose);
        own.reach.iter_mut().zip(padding).for_each(|([.., w], padding)| *w += padding);
        own
    }
}
