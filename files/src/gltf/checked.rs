//! Checks of all that `gltf` takes for granted: without them it panics, reads what is no position, or reads
//! without end.

use crate::budget::Budget;
use crate::error::Fault;
use crate::escape::shown_path;
use crate::folder::Folder;
use crate::format::FIRST_VERSION;
use crate::import::Import;
use base64::Engine;
use base64::engine::general_purpose::STANDARD as BASE64;
use gltf::accessor::Accessor;
use gltf::binary::Glb;
use gltf::buffer::{Buffer, Source};
use gltf::json::accessor::{ComponentType, GenericComponentType, Type};
use gltf::json::validation::Checked;
use gltf::json::{Index, Root, Value, deserialize};
use gltf::{Document, Gltf, Semantic};
use std::borrow::Cow;
use std::collections::{HashMap, HashSet};
use std::fs::File;
use std::io::Read;
use std::path::{Path, PathBuf};

/// Bytes that the least object of a document takes, rounded up.
const OBJECT: usize = 512;

/// A document and the buffer within its file.
pub(super) fn document(bytes: &[u8], import: &mut Import) -> Result<Gltf, Fault> {
    let glb = match bytes.starts_with(b"glTF") {
        true => Some(Glb::from_slice(bytes).map_err(|e| Fault::broken(e.to_string()))?),
        false => None,
    };
    let text = import.text(glb.as_ref().map_or(bytes, |glb| &glb.json));
    import.budget.check(OBJECT * text.iter().filter(|&&b| b == b'{').count())?;
    // Its strings and its binary chunk are copied.
    import.budget.take(bytes.len())?;
    let mut root = root(text, &mut import.notes)?;
    let notes = &mut import.notes;
    for extension in std::mem::take(&mut root.extensions_required) {
        if HARMLESS.split(' ').any(|name| extension.starts_with(name)) {
            notes.push(format!("{extension} is passed over: it leaves geometry alone"));
        } else if !READ.iter().any(|name| extension.starts_with(name)) {
            let what = format!("requires the extension {extension}, which is not read");
            return Err(Fault::broken(what));
        }
    }
    keep_geometry(&mut root);
    let mut has_bounds = true;
    let (accessors, count) = (&mut root.accessors, 3);
    for primitive in root.meshes.iter_mut().flat_map(|mesh| &mut mesh.primitives) {
        let mut used = primitive.attributes.values();
        if let Some(stray) = used.find(|accessor| accessor.value() >= accessors.len()) {
            return Err(Fault::broken(format!("there is no accessor {}", stray.value())));
        }
        let positions = primitive.attributes.get(&Checked::Valid(Semantic::Positions));
        let Some(accessor) = positions.and_then(|at| accessors.get_mut(at.value())) else {
            continue;
        };
        // Beside compressed data there may be others, for readers that do not know it.
        let others = primitive.extensions.as_ref().map(|extensions| &extensions.others);
        let is_compressed = others.is_some_and(|others| others.contains_key(DRACO));
        if is_compressed && accessor.buffer_view.is_none() {
            return Err(compressed(DRACO));
        }
        if accessor.min.is_none() || accessor.max.is_none() {
            has_bounds = false;
            let zeros = || Some(vec![0; count].into());
            (accessor.min, accessor.max) = (zeros(), zeros());
        }
    }
    if !has_bounds {
        notes.push("POSITION has no min and max".to_owned());
    }
    let document = Document::from_json(root).map_err(|e| Fault::broken(e.to_string()))?;
    Ok(Gltf { document, blob: glb.and_then(|glb| glb.bin).map(Cow::into_owned) })
}

/// Lists of a document that hold no geometry.
const OTHERS: [&str; 6] = ["animations", "cameras", "images", "materials", "samplers", "textures"];

/// Reads the text of a document, without what is broken in it and no geometry.
fn root(text: &[u8], notes: &mut Vec<String>) -> Result<Root, Fault> {
    deserialize::from_slice(text).or_else(|error| {
        let broken = Fault::broken(error.to_string());
        let json = deserialize::from_slice::<Value>(text);
        let Ok(Value::Object(mut json)) = json else { return Err(broken) };
        if json.get("meshes").is_some_and(Value::is_object) {
            return Err(Fault::broken(FIRST_VERSION));
        }
        // The specification lets a scene have none, and `gltf` does not.
        let scenes = json.get_mut("scenes").and_then(Value::as_array_mut);
        for scene in scenes.into_iter().flatten().filter_map(Value::as_object_mut) {
            scene.entry("nodes").or_insert(Value::Array(Vec::new()));
        }
        deserialize::from_value(Value::Object(json.clone())).or_else(|_| {
            OTHERS.iter().for_each(|list| drop(json.remove(*list)));
            json.insert("asset".to_owned(), Value::from_iter([("version", "2.0")]));
            notes.push(format!("passed over, as it is no geometry: {error}"));
            deserialize::from_value(Value::Object(json)).map_err(|_| broken)
        })
    })
}

/// Leaves out all that is no geometry: it may be as it likes.
fn keep_geometry(root: &mut Root) {
    let mut used = HashSet::new();
    for primitive in root.meshes.iter_mut().flat_map(|mesh| &mut mesh.primitives) {
        primitive.material = None;
        primitive.attributes.retain(|semantic, _| {
            use Semantic::{Joints, Positions, Weights};
            matches!(semantic, Checked::Valid(Positions | Joints(_) | Weights(_)))
        });
        used.extend(primitive.attributes.values().map(Index::value));
        used.extend(primitive.indices.as_ref().map(Index::value));
        for target in primitive.targets.iter_mut().flatten() {
            (target.normals, target.tangents) = (None, None);
            used.extend(target.positions.as_ref().map(Index::value));
        }
    }
    used.extend(root.skins.iter().filter_map(|skin| Some(skin.inverse_bind_matrices?.value())));
    for node in &mut root.nodes {
        node.camera = None;
        let others = node.extensions.as_ref().map(|extensions| &extensions.others);
        let instancing =
            others.and_then(|others| others.get(INSTANCING)?["attributes"].as_object());
        let accessors = instancing.into_iter().flat_map(|attributes| attributes.values());
        used.extend(accessors.filter_map(|accessor| Some(accessor.as_u64()? as usize)));
    }
    for (number, accessor) in root.accessors.iter_mut().enumerate() {
        if !used.contains(&number) {
            accessor.component_type = Checked::Valid(GenericComponentType(ComponentType::F32));
            accessor.type_ = Checked::Valid(Type::Scalar);
            // The first view, if there is one, is as good as any.
            accessor.buffer_view = root.buffer_views.first().map(|_| Index::new(0));
            (accessor.sparse, accessor.min, accessor.max) = (None, None, None);
        }
    }
    root.buffer_views.iter_mut().for_each(|view| view.target = None);
    root.materials.clear();
    root.textures.clear();
    root.images.clear();
    root.samplers.clear();
    root.animations.clear();
    root.cameras.clear();
}

fn compressed(extension: &str) -> Fault {
    Fault::broken(format!("is compressed with {extension}, which is not read"))
}

/// Places a mesh many times.
pub(super) const INSTANCING: &str = "EXT_mesh_gpu_instancing";
const DRACO: &str = "KHR_draco_mesh_compression";
const MESHOPT: [&str; 2] = ["EXT_meshopt_compression", "KHR_meshopt_compression"];

/// Extensions of what is read.
const READ: [&str; 2] = ["KHR_mesh_quantization", INSTANCING];

/// Beginnings of the names of extensions that leave geometry alone.
const HARMLESS: &str = "KHR_technique KHR_node_ KHR_physics_ KHR_interactivity KHR_environment_map KHR_materials_ KHR_texture_ \
    KHR_lights_ KHR_xmp KHR_animation_pointer KHR_audio ADOBE_materials_ AGI_ CESIUM_primitive_outline EXT_mesh_manifold \
    EXT_texture_ EXT_lights_ EXT_materials_ EXT_mesh_features EXT_instance_features EXT_structural_metadata EXT_feature_metadata \
    FB_geometry_metadata GRIFFEL_bim_data MSFT_lod MSFT_packing_ MSFT_texture_ NV_materials_ OMI_ VRM";

/// The bytes of all buffers, those of one file once.
pub(crate) struct Buffers {
    /// For each buffer of the document the number of its data.
    numbers: Vec<usize>,
    data: Vec<Vec<u8>>,
}

impl Buffers {
    /// Reads buffers: in the file, in its text, or in files beside, whose bytes count as the file's. No more of a file is read
    /// than the longest of its buffers has.
    pub(crate) fn load(
        document: &Document,
        mut blob: Option<Vec<u8>>,
        folder: &Folder<'_>,
        budget: &mut Budget,
    ) -> Result<Self, Fault> {
        let mut paths: HashMap<&str, PathBuf> = HashMap::new();
        let mut lengths: HashMap<PathBuf, usize> = HashMap::new();
        for buffer in document.buffers() {
            let Some(uri) = uri(&buffer) else { continue };
            let path = match paths.get(uri) {
                Some(path) => path.clone(),
                None => folder.file(uri).map_err(|fault| in_buffer(&buffer, fault))?,
            };
            let longest = lengths.entry(path.clone()).or_default();
            *longest = buffer.length().max(*longest);
            paths.insert(uri, path);
        }
        let mut files: HashMap<&PathBuf, usize> = HashMap::new();
        let mut all = Self { numbers: Vec::new(), data: Vec::new() };
        for buffer in document.buffers() {
            let path = uri(&buffer).and_then(|uri| paths.get(uri));
            let known = path.and_then(|path| files.get(path).copied());
            all.numbers.push(known.unwrap_or(all.data.len()));
            if known.is_some() {
                continue;
            }
            let data = match path {
                Some(path) => {
                    files.insert(path, all.data.len());
                    read(path, lengths[path], budget)
                }
                None => inline(&buffer, &mut blob, budget),
            };
            all.data.push(data.map_err(|fault| in_buffer(&buffer, fault))?);
        }
        Ok(all)
    }

    pub(crate) fn get(&self, buffer: usize) -> Option<&[u8]> {
        Some(&self.data[*self.numbers.get(buffer)?])
    }

    fn bytes(&self) -> usize {
        self.data.iter().map(Vec::len).sum()
    }
}

/// Names the buffer that a fault is in.
fn in_buffer(buffer: &Buffer<'_>, fault: Fault) -> Fault {
    fault.within(format_args!("buffer {}", buffer.index()))
}

/// The name of the file that a buffer is in, unless that is the file of the document.
fn uri<'d>(buffer: &Buffer<'d>) -> Option<&'d str> {
    match buffer.source() {
        Source::Uri(uri) if !uri.starts_with("data:") => Some(uri),
        _ => None,
    }
}

/// A buffer in the file of the document or in its text.
fn inline(
    buffer: &Buffer<'_>,
    blob: &mut Option<Vec<u8>>,
    budget: &mut Budget,
) -> Result<Vec<u8>, Fault> {
    let Source::Uri(uri) = buffer.source() else {
        // Stands for data that is compressed elsewhere.
        if MESHOPT.into_iter().any(|name| buffer.extension_value(name).is_some()) {
            return Ok(Vec::new());
        }
        return blob.take().ok_or_else(|| Fault::broken("the file has no binary chunk"));
    };
    // Six bits a character.
    budget.take(uri.len() - uri.len() / 4)?;
    let text = uri.split_once(";base64,").map(|(_, text)| text);
    let text = text.ok_or_else(|| Fault::broken("a data URI that is not in base64"))?;
    BASE64.decode(text).map_err(|error| Fault::broken(error.to_string()))
}

/// The first `length` bytes of a file, which must have as many.
fn read(path: &Path, length: usize, budget: &mut Budget) -> Result<Vec<u8>, Fault> {
    let fault = |what: String| Fault::broken(format!("{}: {what}", shown_path(path)));
    let io = |error: std::io::Error| fault(error.to_string());
    let file = File::open(path).map_err(io)?;
    let found = file.metadata().map_err(io)?.len();
    if found < length as u64 {
        return Err(fault(format!("has {found} bytes, and {length} by the document")));
    }
    budget.add_file(length);
    budget.take(length)?;
    let mut data = Vec::new();
    data.try_reserve_exact(length + 1).map_err(|error| fault(error.to_string()))?;
    file.take(length as u64).read_to_end(&mut data).map_err(io)?;
    Ok(data)
}

/// Checks that an accessor has entries, and all of them in its buffer.
pub(super) fn inside(accessor: &Accessor<'_>, buffers: &Buffers) -> Result<(), Fault> {
    let fault = || {
        let at = accessor.index();
        Fault::broken(format!("accessor {at} is empty, overlaps itself or leaves its buffer"))
    };
    let count = accessor.count();
    let dense = accessor.view().map(|view| (view, accessor.offset(), count, accessor.size()));
    let sparse = accessor.sparse().map(|sparse| {
        let (indices, values) = (sparse.indices(), sparse.values());
        [
            (indices.view(), indices.offset(), sparse.count(), indices.index_type().size()),
            (values.view(), values.offset(), sparse.count(), accessor.size()),
        ]
    });
    let views = accessor.view().into_iter();
    for view in views {
        if let Some(name) = MESHOPT.into_iter().find(|name| view.extension_value(name).is_some()) {
            return Err(compressed(name));
        }
    }
    for (view, offset, count, size) in dense.into_iter().chain(sparse.into_iter().flatten()) {
        let stride = view.stride().unwrap_or(size);
        let last = count.checked_sub(1).and_then(|last| last.checked_mul(stride));
        let end = last.and_then(|last| last.checked_add(size)?.checked_add(offset));
        let view_end = view.offset().checked_add(view.length()).ok_or_else(fault)?;
        let buffer = buffers.get(view.buffer().index()).map_or(0, <[u8]>::len);
        if stride < size || end.is_none_or(|end| end > view.length()) || view_end > buffer {
            return Err(fault());
        }
    }
    // Without a view all is zero, and takes no bytes however much there is of it.
    if accessor.view().is_none() && count > buffers.bytes() {
        return Err(fault());
    }
    Ok(())
}
