//! Tests without an adapter: every pass is valid WGSL, and its structs are those of Rust.

use crate::layout::SHARED;
use crate::pass::rounds;
use crate::results::REST_AT;
use crate::settings::{Budget, Capacities};
use naga::valid::{Capabilities, ModuleInfo, ValidationFlags, Validator};
use naga::{
    AddressSpace, Barrier, Block, Expression, Function, GlobalVariable, Handle, Module, Statement,
    TypeInner,
};
use pfront_core::Node;
use pfront_core::bvh::MAX_LEAF_SIZE;
use pfront_shaders::{Access, Binding, PASSES, Pass, constants};
use std::collections::BTreeSet;
use std::mem::offset_of;

#[test]
fn every_pass_is_valid_and_stays_within_the_limits_of_webgpu() {
    let (limits, mut large) = (wgpu::Limits::default(), Vec::new());
    for pass in PASSES {
        let (module, info) = parse(&pass);
        let [entry] = &module.entry_points[..] else { panic!("{}: entry points", pass.entry) };
        assert_eq!(entry.name, pass.entry);
        assert_eq!(entry.workgroup_size, [constants::GROUP, 1, 1]);
        assert!(constants::GROUP <= limits.max_compute_invocations_per_workgroup);

        let storage = pass.bindings().filter(|own| own.access != Access::Uniform);
        assert!(storage.count() <= limits.max_storage_buffers_per_shader_stage as usize);

        let used = info.get_entry_point(0);
        let shared = module.global_variables.iter().filter(|(handle, variable)| {
            variable.space == naga::AddressSpace::WorkGroup && !used[*handle].is_empty()
        });
        let bytes: u32 = shared.map(|(_, v)| module.types[v.ty].inner.size(module.to_ctx())).sum();
        assert!(bytes <= limits.max_compute_workgroup_storage_size, "{}: {bytes}", pass.entry);
        if bytes > 12_288 {
            large.push(pass.entry);
        }
    }
    // Above that a multiprocessor of an H100 runs three workgroups at a time in place of four.
    assert_eq!(large, ["dive", "arrange"]);
}

/// Parses and validates a pass.
fn parse(pass: &Pass) -> (Module, ModuleInfo) {
    let source = pass.source();
    let module = naga::front::wgsl::parse_str(&source)
        .unwrap_or_else(|error| panic!("{}: {}", pass.entry, error.emit_to_string(&source)));
    let info = Validator::new(ValidationFlags::all(), Capabilities::default())
        .validate(&module)
        .unwrap_or_else(|error| panic!("{}: {}", pass.entry, error.emit_to_string(&source)));
    (module, info)
}

/// A layout with more buffers than the entry point uses could go beyond the limits, and one with fewer is refused.
#[test]
fn passes_bind_the_buffers_and_overrides_that_they_use() {
    for pass in PASSES {
        let (module, info) = parse(&pass);
        let entry = info.get_entry_point(0);
        let variables = module.global_variables.iter();
        let used = variables.filter(|(handle, _)| !entry[*handle].is_empty());
        let mut used: Vec<_> = used.filter_map(|(_, variable)| bound(variable)).collect();
        let tuple = |own: Binding| (own.name.to_owned(), own.group, own.binding, own.access);
        let mut named: Vec<_> = pass.bindings().map(tuple).collect();
        used.sort();
        named.sort();
        assert_eq!(used, named, "{}", pass.entry);

        let names: Vec<_> =
            module.overrides.iter().filter_map(|(_, own)| own.name.as_deref()).collect();
        for name in ["ARITHMETIC", "MOST_ROUNDS", "CERTIFY"] {
            assert_eq!(pass.has_override(name), names.contains(&name), "{name}");
        }
    }
}

/// A variable of naga that is a buffer, as [`Binding`] has it.
fn bound(variable: &GlobalVariable) -> Option<(String, u32, u32, Access)> {
    let at = variable.binding?;
    let access = match variable.space {
        AddressSpace::Uniform => Access::Uniform,
        AddressSpace::Storage { access } if access.contains(naga::StorageAccess::STORE) => {
            Access::ReadWrite
        }
        _ => Access::Read,
    };
    Some((variable.name.clone()?, at.group, at.binding, access))
}

const NODE: (&str, usize, &[(&str, usize)]) = (
    "Node",
    size_of::<Node>(),
    &[
        ("min", offset_of!(Node, min)),
        ("first", offset_of!(Node, first)),
        ("max", offset_of!(Node, max)),
        ("count", offset_of!(Node, count)),
    ],
);

#[test]
fn structs_have_the_same_layout_in_wgsl_and_in_rust() {
    let mut compared = BTreeSet::new();
    for pass in PASSES {
        let (module, _) = parse(&pass);
        for &(name, size, fields) in SHARED.iter().chain([&NODE]) {
            let Some(found) = layout(&module, name) else { continue };
            let fields: Vec<_> =
                fields.iter().filter(|(field, _)| !field.starts_with("padding")).collect();
            let fields: Vec<_> = fields.iter().map(|(field, at)| (*field, *at)).collect();
            assert_eq!(found, (size, fields), "{name}");
            compared.insert(name);
        }
    }
    assert_eq!(compared.len(), SHARED.len() + 1, "{compared:?}");
    let (module, _) = parse(&pfront_shaders::ORDER);
    let (_, fields) = layout(&module, "ReadBack").unwrap();
    assert_eq!(fields.last(), Some(&("rest", REST_AT as usize)));
}

/// naga 30 decorates no buffer as coherent, so that one invocation may never see what another of its
/// dispatch has stored, barrier or not. All buffers that a pass both reads and stores to are listed here, with
/// the reason why it may.
#[test]
fn no_pass_reads_storage_that_other_invocations_of_its_dispatch_write() {
    let mut found = BTreeSet::new();
    for pass in PASSES {
        let (module, _) = parse(&pass);
        let functions = module.functions.iter().map(|(_, function)| function);
        let mut access = StorageAccess::default();
        functions.chain([&module.entry_points[0].function]).for_each(|function| {
            access.add(&module, function, &function.body);
        });
        assert!(!access.has_barrier, "{} orders accesses of storage by a barrier", pass.entry);
        found.extend(
            access.loads.intersection(&access.stores).map(|name| (pass.entry, name.clone())),
        );
    }
    let own = [
        // Vertices of corners, of which only positions are written.
        ("fit", "corners"),
        ("refit", "corners"),
        // Boxes of earlier dispatches, and links, which do not change.
        ("fit", "nodes"),
        ("refit", "nodes"),
        // Atomics, which one invocation has at 0 again after all have read them, and words that no pass reads.
        ("bring", "counters"),
        ("order", "counters"),
        ("settle", "counters"),
        // Each invocation reads and writes elements that are its own.
        ("keys", "entries_out"),
        ("probe", "trials"),
        ("scan", "table"),
    ];
    assert_eq!(found, own.map(|(pass, name)| (pass, name.to_owned())).into());
}

/// Buffers that are loaded and stored, atomics apart.
#[derive(Default)]
struct StorageAccess {
    loads: BTreeSet<String>,
    stores: BTreeSet<String>,
    has_barrier: bool,
}

impl StorageAccess {
    fn add(&mut self, module: &Module, function: &Function, block: &Block) {
        let buffer = |pointer| {
            global(module, function, pointer, |space| matches!(space, AddressSpace::Storage { .. }))
        };
        for statement in block {
            match statement {
                Statement::ControlBarrier(barrier) | Statement::MemoryBarrier(barrier) => {
                    self.has_barrier |= barrier.contains(Barrier::STORAGE);
                }
                Statement::Emit(range) => {
                    for expression in range.clone() {
                        if let Expression::Load { pointer } = function.expressions[expression] {
                            self.loads.extend(buffer(pointer));
                        }
                    }
                }
                Statement::Store { pointer, .. } => self.stores.extend(buffer(*pointer)),
                _ => {}
            }
            blocks(statement).into_iter().for_each(|block| self.add(module, function, block));
        }
    }
}

/// Idle teams have no data: what they read would be memory that nothing has written.
#[test]
fn teams_read_workgroup_memory_under_a_condition() {
    let (module, _) = parse(&pfront_shaders::DECIDE);
    let unconditional = unconditional_loads(&module, &module.entry_points[0].function);
    for name in ["corners", "doubts", "widths", "first_signs", "second_signs", "lattice"] {
        let exists = module.global_variables.iter().any(|(_, v)| v.name.as_deref() == Some(name));
        assert!(exists && !unconditional.contains(name), "{name}");
    }
}

/// Variables of workgroup memory that a pass loads outside of any condition, but for those in the body of
/// its entry point.
fn unconditional_loads(module: &Module, entry: &Function) -> BTreeSet<String> {
    let mut loads = BTreeSet::new();
    let mut waiting = vec![(entry, &entry.body, true)];
    while let Some((function, block, is_entry)) = waiting.pop() {
        for statement in block {
            match statement {
                Statement::Call { function: callee, .. } => {
                    let callee = &module.functions[*callee];
                    waiting.push((callee, &callee.body, false));
                }
                Statement::Emit(range) => {
                    for expression in range.clone() {
                        if let Expression::Load { pointer } = function.expressions[expression] {
                            loads.extend(global(module, function, pointer, |space| {
                                space == AddressSpace::WorkGroup
                            }));
                        }
                    }
                }
                Statement::If { .. } | Statement::Switch { .. } if !is_entry => {}
                _ => waiting.extend(blocks(statement).into_iter().map(|b| (function, b, is_entry))),
            }
        }
    }
    loads
}

/// The name of the variable that a pointer points into, if it lies in such a space.
fn global(
    module: &Module,
    function: &Function,
    pointer: Handle<Expression>,
    is_wanted: impl Fn(AddressSpace) -> bool,
) -> Option<String> {
    let mut at = pointer;
    loop {
        match function.expressions[at] {
            Expression::Access { base, .. } | Expression::AccessIndex { base, .. } => at = base,
            Expression::GlobalVariable(variable) => {
                let variable = &module.global_variables[variable];
                return is_wanted(variable.space)
                    .then(|| variable.name.clone().unwrap_or_default());
            }
            _ => return None,
        }
    }
}

/// The blocks within a statement.
fn blocks(statement: &Statement) -> Vec<&Block> {
    match statement {
        Statement::Block(block) => vec![block],
        Statement::If { accept, reject, .. } => vec![accept, reject],
        Statement::Switch { cases, .. } => cases.iter().map(|case| &case.body).collect(),
        Statement::Loop { body, continuing, .. } => vec![body, continuing],
        _ => vec![],
    }
}

/// Queries load nodes and corners as vectors of words: what is decoded from them is what Rust has there.
#[test]
fn words_are_decoded_by_the_layout_of_rust() {
    let corner = SHARED.iter().find(|(name, ..)| *name == "Corner").unwrap();
    let mut compared = BTreeSet::new();
    for pass in PASSES {
        let (module, _) = parse(&pass);
        for (_, buffer) in module.global_variables.iter() {
            let size = match buffer.name.as_deref() {
                Some("nodes_a" | "nodes_b") => size_of::<Node>(),
                Some("corners_a" | "corners_b") => corner.1,
                _ => continue,
            };
            let TypeInner::Array { stride, .. } = module.types[buffer.ty].inner else {
                panic!("{:?}", buffer.name)
            };
            assert_eq!(stride as usize, size, "{}: {:?}", pass.entry, buffer.name);
        }
        for (_, function) in module.functions.iter() {
            let layout = match function.name.as_deref() {
                Some("node_of") => NODE.2,
                Some("corner_of") => corner.2,
                _ => continue,
            };
            let of_rust: Vec<_> = layout.iter().map(|(_, offset)| *offset).collect();
            assert_eq!(decoded(function), of_rust, "{}: {:?}", pass.entry, function.name);
            compared.insert(function.name.clone());
        }
    }
    assert_eq!(compared.len(), 2);
}

/// The byte within the argument of a function where each component of its result comes from.
fn decoded(function: &Function) -> Vec<usize> {
    let offset = |from: Handle<Expression>| {
        let (mut at, mut words) = (from, 0);
        loop {
            // An index counts words in a vector, and vectors of four words in an array of them.
            let (base, index) = match function.expressions[at] {
                Expression::As { expr, convert: None, .. } => (expr, 0),
                Expression::Swizzle { vector, pattern: [x, y, z, _], .. } => {
                    assert_eq!([y as usize, z as usize], [x as usize + 1, x as usize + 2]);
                    (vector, x as usize)
                }
                Expression::AccessIndex { base, index } => {
                    (base, if at == from { index as usize } else { 4 * index as usize })
                }
                Expression::FunctionArgument(0) => return 4 * words,
                ref other => panic!("{other:?}"),
            };
            (at, words) = (base, words + index);
        }
    };
    let is_result = |statement: &&Statement| matches!(statement, Statement::Return { .. });
    let Some(Statement::Return { value: Some(result) }) = function.body.iter().find(is_result)
    else {
        panic!("{:?} returns nothing", function.name)
    };
    let Expression::Compose { components, .. } = &function.expressions[*result] else {
        panic!("{:?} composes nothing", function.name)
    };
    components.iter().map(|&component| offset(component)).collect()
}

#[test]
fn only_adapters_that_run_on_the_cpu_count_rounds_closely() {
    let [cpu, discrete, unknown] =
        [wgpu::DeviceType::Cpu, wgpu::DeviceType::DiscreteGpu, wgpu::DeviceType::Other].map(rounds);
    assert!(cpu < discrete && discrete == unknown);
    for pass in [
        pfront_shaders::SEED,
        pfront_shaders::EXPAND,
        pfront_shaders::NARROW,
        pfront_shaders::DECIDE,
    ] {
        let (module, _) = parse(&pass);
        let mut names = module.overrides.iter().filter_map(|(_, own)| own.name.as_deref());
        assert!(names.any(|name| name == "MOST_ROUNDS"), "{}", pass.entry);
    }
}

fn layout<'m>(module: &'m Module, name: &str) -> Option<(usize, Vec<(&'m str, usize)>)> {
    let mut types = module.types.iter().map(|(_, ty)| ty);
    let found = types.find(|ty| ty.name.as_deref() == Some(name))?;
    let TypeInner::Struct { members, span } = &found.inner else { return None };
    let field = |m: &'m naga::StructMember| Some((m.name.as_deref()?, m.offset as usize));
    Some((*span as usize, members.iter().filter_map(field).collect()))
}

#[test]
fn constants_fit_together() {
    use constants::{CHUNK, FRONTS, GROUP, MOST_LEAF, QUEUE, RESULTS};
    assert_eq!(MOST_LEAF, MAX_LEAF_SIZE);
    const {
        assert!(RESULTS >= 2 * GROUP);
        assert!(4 * CHUNK <= QUEUE && CHUNK <= GROUP && GROUP <= QUEUE);
    }
    assert!(FRONTS as usize > pfront_core::bvh::MAX_DEPTH + 1);
    let least = Capacities::new(Budget::LEAST).unwrap();
    let lists = [least.front / 4, least.leaves, least.hits, least.kept, least.rest];
    assert!(lists.iter().all(|&n| n >= MOST_LEAF * MOST_LEAF));
}
