//! Bodies out of one file: the same assembly in every format that has some; and poses that a file puts them into.

use super::lenient::read;
use pfront::{Model, PairQuery, Pose};
use pfront_files::MeshFile;
use std::io::{Cursor, Write};
use zip::ZipWriter;
use zip::write::SimpleFileOptions;

pub(super) const PLATE: [[f32; 3]; 3] = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]];
pub(super) const PIN: [[f32; 3]; 3] = [[0.25, 0.25, -1.0], [0.375, 0.25, -1.0], [0.25, 0.375, 1.0]];

pub(super) fn obj(statement: &str) -> String {
    let vertices = |body: [[f32; 3]; 3]| body.map(|[x, y, z]| format!("v {x} {y} {z}\n")).concat();
    let [plate, pin] = [PLATE, PIN].map(vertices);
    format!("{statement} plate\n{plate}f 1 2 3\n{statement} pin\n{pin}f 4 5 6\n")
}

fn stl() -> String {
    let solid = |name, body: [[f32; 3]; 3]| {
        let corners = body.map(|[x, y, z]| format!("vertex {x} {y} {z}\n")).concat();
        format!(
            "solid {name}\nfacet normal 0 0 0\nouter loop\n{corners}endloop\nendfacet\nendsolid\n"
        )
    };
    solid("plate", PLATE) + &solid("pin", PIN)
}

/// A document of two meshes and some nodes; the buffer holds the plate, the pin, and numbers that follow.
pub(super) fn gltf(nodes: &str, rest: &str, more: &[u8]) -> Vec<u8> {
    let corners = [PLATE, PIN];
    let buffer = [bytemuck::cast_slice(corners.as_flattened().as_flattened()), more].concat();
    let length = buffer.len();
    let json = format!(
        r#"{{"asset":{{"version":"2.0"}},"scenes":[{{"nodes":[0,1]}}],"nodes":[{nodes}],{rest}
        "bufferViews":[{{"buffer":0,"byteLength":36}},{{"buffer":0,"byteOffset":36,"byteLength":36}},
        {{"buffer":0,"byteOffset":72,"byteLength":{}}}],"buffers":[{{"byteLength":{length}}}]}}"#,
        (length - 72).max(1)
    );
    let mut json = json.into_bytes();
    json.resize(json.len().next_multiple_of(4), b' ');
    let chunk =
        |kind: &[u8], data: &[u8]| [&(data.len() as u32).to_le_bytes(), kind, data].concat();
    let chunks = [chunk(b"JSON", &json), chunk(b"BIN\0", &buffer)].concat();
    [b"glTF\x02\0\0\0", &(12 + chunks.len() as u32).to_le_bytes()[..], &chunks].concat()
}

pub(super) const NODES: &str = r#"{"mesh":0,"name":"plate"},{"mesh":1,"name":"pin"}"#;

/// The accessors of the plate and the pin, and others.
pub(super) fn meshes(attributes: &str, accessors: &str) -> String {
    format!(
        r#""meshes":[{{"primitives":[{{"attributes":{{"POSITION":0}}}}]}},
        {{"primitives":[{{"attributes":{{"POSITION":1{attributes}}}}}]}}],"accessors":[
        {{"bufferView":0,"componentType":5126,"count":3,"type":"VEC3","min":[0,0,0],"max":[1,1,0]}},
        {{"bufferView":1,"componentType":5126,"count":3,"type":"VEC3","min":[0,0,-1],"max":[1,1,1]}}{accessors}],"#
    )
}

pub(super) fn archive(parts: &[(&str, &str)]) -> Vec<u8> {
    let mut zip = ZipWriter::new(Cursor::new(Vec::new()));
    for (name, text) in parts {
        zip.start_file(*name, SimpleFileOptions::default()).unwrap();
        zip.write_all(text.as_bytes()).unwrap();
    }
    zip.finish().unwrap().into_inner()
}

pub(super) fn object(id: u32, name: &str, body: [[f32; 3]; 3]) -> String {
    let vertex = |[x, y, z]: [f32; 3]| format!("<vertex x=\"{x}\" y=\"{y}\" z=\"{z}\"/>\n");
    let vertices = body.map(vertex).concat();
    format!(
        "<object id=\"{id}\" name=\"{name}\"><mesh><vertices>{vertices}</vertices><triangles>\
         <triangle v1=\"0\" v2=\"1\" v3=\"2\"/></triangles></mesh></object>"
    )
}

pub(super) fn model(attributes: &str, resources: &str, items: &str) -> String {
    format!(
        "<?xml version=\"1.0\"?>\n<model unit=\"millimeter\" xmlns=\"http://schemas.microsoft.com/3dmanufacturing/core/2015/02\" \
         {attributes}><resources>{resources}</resources><build>{items}</build></model>"
    )
}

pub(super) fn three_mf() -> Vec<u8> {
    let [x, y, z] = [2.0, 0.0, 5.0];
    let moved = PIN.map(|p| [p[0] - x, p[1] - y, p[2] - z]);
    let resources = object(1, "plate", PLATE) + &object(2, "pin", moved);
    let items = format!(
        "<item objectid=\"1\"/><item objectid=\"2\" transform=\"1 0 0 0 1 0 0 0 1 {x} {y} {z}\"/>"
    );
    archive(&[("3D/3dmodel.model", &model("", &resources, &items))])
}

/// The names of the bodies, their corners, and how many pairs of triangles of the first two meet.
fn bodies(file: &MeshFile) -> (Vec<String>, Vec<Vec<[f64; 3]>>, usize) {
    let triangles = file.source.triangles(file.mesh.triangles.len());
    let parts: Vec<_> = triangles.iter().map(|triangles| file.mesh.part(triangles)).collect();
    let corners = |part: &pfront_files::TriangleMesh| {
        part.triangles.as_flattened().iter().map(|&v| part.positions[v as usize]).collect()
    };
    let models: Vec<_> = (parts.iter())
        .map(|part| Model::from_f64(part.positions.clone(), part.triangles.clone()).unwrap())
        .collect();
    let pairs = PairQuery::new().all(&models[0], &models[1], Pose::IDENTITY).unwrap().len();
    (file.source.bodies().to_vec(), parts.iter().map(corners).collect(), pairs)
}

#[test]
fn an_assembly_is_the_same_in_every_format() {
    let expected = [PLATE, PIN].map(|body| body.map(|p| p.map(f64::from)).to_vec());
    for (format, bytes) in [
        ("obj", obj("o").into_bytes()),
        ("obj", obj("g").into_bytes()),
        ("stl", stl().into_bytes()),
        ("glb", gltf(NODES, &meshes("", ""), &[])),
        ("3mf", three_mf()),
    ] {
        let (names, corners, pairs) = bodies(&read(format, bytes).unwrap());
        assert_eq!(names, ["plate", "pin"], "{format}");
        assert_eq!(corners, expected, "{format}");
        assert_eq!(pairs, 1, "{format}");
    }
}

#[test]
fn objects_of_an_obj_go_on_and_groups_are_parts_of_them() {
    let more =
        obj("g") + "o lid\ng left\nf 1 2 3\ng right\nf 4 5 6\no pin\nf 1 3 2\no lid\nf 1 2 3\n";
    let file = read("obj", more).unwrap();
    // The first two are of no object.
    assert_eq!(file.source.bodies(), ["default", "lid", "pin"]);
    let triangles = file.source.triangles(6);
    assert_eq!(triangles, [vec![0, 1], vec![2, 3, 5], vec![4]]);
    assert_eq!(file.source.body(5), Some("lid"));
    let twice = read("stl", stl().replace("solid pin", "solid plate")).unwrap();
    assert_eq!(twice.source.bodies(), ["plate", "plate (2)"]);
}

const INSTANCES: &str = r#"{"mesh":0,"name":"bolt","translation":[0,0,1],"extensions":{"EXT_mesh_gpu_instancing":
    {"attributes":{"TRANSLATION":2}}}},{"mesh":1,"name":"pin"}"#;
const PLACES: &str = r#",{"bufferView":2,"componentType":5126,"count":2,"type":"VEC3"}"#;

/// A plate placed twice, and the pin.
pub(super) fn instanced() -> Vec<u8> {
    let places = [[0.0_f32, 0.0, 0.0], [3.0, 0.0, 0.0]];
    gltf(INSTANCES, &meshes("", PLACES), bytemuck::cast_slice(&places))
}

#[test]
fn instances_are_bodies() {
    let (names, corners, _) = bodies(&read("glb", instanced()).unwrap());
    assert_eq!(names, ["bolt", "bolt (2)", "pin"]);
    assert_eq!(corners[1], [[3.0, 0.0, 1.0], [4.0, 0.0, 1.0], [3.0, 1.0, 1.0]]);
    let stray = INSTANCES.replace("\"TRANSLATION\":2", "\"SCALE\":7");
    let stray = read("glb", gltf(&stray, &meshes("", PLACES), &[])).unwrap_err();
    assert!(stray.contains("no accessor 7"), "{stray}");
}

/// The pin with one joint at x = 5.
fn of_joint(joint: u8) -> Vec<u8> {
    let skin = r#""skins":[{"joints":[2]}],"#;
    let nodes = r#"{"mesh":0,"name":"plate"},{"mesh":1,"skin":0,"name":"pin","translation":[0,9,0],"children":[2]},
        {"name":"joint","translation":[5,-9,0]}"#;
    let accessors = r#",{"bufferView":2,"componentType":5121,"count":3,"type":"VEC4"},
        {"bufferView":2,"byteOffset":12,"componentType":5121,"normalized":true,"count":3,"type":"VEC4"}"#;
    let more = [[[joint; 4]; 3], [[255, 0, 0, 0]; 3]].concat().concat();
    gltf(nodes, &(meshes(r#","JOINTS_0":2,"WEIGHTS_0":3"#, accessors) + skin), &more)
}

/// The pin with all weight on a joint.
pub(super) fn skinned() -> Vec<u8> {
    of_joint(0)
}

#[test]
fn meshes_stand_as_the_file_poses_them() {
    let (_, corners, _) = bodies(&read("glb", skinned()).unwrap());
    assert_eq!(corners[1], PIN.map(|[x, y, z]| [x + 5.0, y, z].map(f64::from)));
    let stray = read("glb", of_joint(1)).unwrap_err();
    assert!(stray.contains("a joint 1 of no skin"), "{stray}");

    // A morph target of weight 1/2.
    let moves = [[4.0_f32, 0.0, 0.0]; 3];
    let target = r#",{"bufferView":2,"componentType":5126,"count":3,"type":"VEC3"}"#;
    let rest = meshes("", target).replace(
        r#""POSITION":1}}]}"#,
        r#""POSITION":1},"targets":[{"POSITION":2}]}],"weights":[0.5]}"#,
    );
    let bytes = gltf(NODES, &rest, bytemuck::cast_slice(&moves));
    let (_, corners, _) = bodies(&read("glb", bytes).unwrap());
    assert_eq!(corners[1], PIN.map(|[x, y, z]| [x + 2.0, y, z].map(f64::from)));
}

/// The pin, of which one corner is another.
fn with_corner(index: u32) -> Vec<u8> {
    let more = [&index.to_le_bytes()[..], bytemuck::cast_slice(&[7.0_f32, 8.0, 9.0])].concat();
    let sparse = r#""max":[1,1,1],"sparse":{"count":1,"indices":{"bufferView":2,"componentType":5125},
        "values":{"bufferView":2,"byteOffset":4}}}"#;
    gltf(NODES, &meshes("", "").replace(r#""max":[1,1,1]}"#, sparse), &more)
}

pub(super) fn sparse() -> Vec<u8> {
    with_corner(1)
}

#[test]
fn quantized_and_sparse_positions() {
    let quantized = |kind: u32, normalized: bool, more: &[u8]| {
        let accessor = format!(
            r#",{{"bufferView":2,"componentType":{kind},"normalized":{normalized},"count":3,"type":"VEC3"}}"#
        );
        let rest = meshes("", &accessor).replace("\"POSITION\":1", "\"POSITION\":2");
        bodies(&read("glb", gltf(NODES, &rest, more)).unwrap()).1[1].clone()
    };
    let shorts: [i16; 9] = [0, 0, 32767, -32767, 0, 0, 0, 32767, 0];
    let bytes = bytemuck::cast_slice(&shorts);
    assert_eq!(quantized(5122, true, bytes), [[0.0, 0.0, 1.0], [-1.0, 0.0, 0.0], [0.0, 1.0, 0.0]]);
    assert_eq!(quantized(5122, false, bytes)[0], [0.0, 0.0, 32767.0]);
    let bytes = [0_u8, 0, 255, 51, 0, 0, 0, 255, 0];
    assert_eq!(quantized(5121, true, &bytes)[1], [0.2, 0.0, 0.0]);

    let (_, corners, _) = bodies(&read("glb", sparse()).unwrap());
    assert_eq!(corners[1][1], [7.0, 8.0, 9.0]);
    assert_eq!(corners[1][0], PIN[0].map(f64::from));
    assert!(read("glb", with_corner(9)).unwrap_err().contains("element 9"));
}

#[test]
fn a_3mf_of_several_parts() {
    let relations = "<Relationships><Relationship Type=\"http://schemas.microsoft.com/3dmanufacturing/2013/01/3dmodel\" \
        Target=\"/3D/start.model\" Id=\"r\"/></Relationships>";
    let other = model("", &object(7, "", PIN), "");
    let production = "xmlns:p=\"http://schemas.microsoft.com/3dmanufacturing/production/2015/06\" requiredextensions=\"p\"";
    let resources = object(1, "plate &amp; co", PLATE)
        + "<object id=\"2\"><components><component objectid=\"1\" transform=\"0 1 0 -1 0 0 0 0 1 0 0 0\"/>\
           <component objectid=\"7\" p:path=\"/3D/other.model\"/></components></object>";
    let items = "<item objectid=\"1\"/><item objectid=\"2\" partnumber=\"A-1\"/>";
    let start = model(production, &resources, items);
    let parts =
        [("_rels/.rels", relations), ("3D/start.model", &start), ("3D/other.model", &other)];
    let (names, corners, _) = bodies(&read("3mf", archive(&parts)).unwrap());
    assert_eq!(names, ["plate & co", "A-1"]);
    // A quarter turn about z, in rows, and the pin.
    assert_eq!(corners[1][..3], [[0.0, 0.0, 0.0], [0.0, 1.0, 0.0], [-1.0, 0.0, 0.0]]);
    assert_eq!(corners[1][3..], PIN.map(|p| p.map(f64::from)));

    let fault = |from: &str, to: &str| {
        assert!(start.contains(from), "{from}");
        let start = start.replace(from, to);
        read("3mf", archive(&[parts[0], ("3D/start.model", &start), parts[2]])).unwrap_err()
    };
    for (from, to, what) in [
        ("production/2015/06", "beamlattice/2017/02", "line 2: requires the extension p"),
        ("v3=\"2\"", "v3=\"3\"", "no vertex 3 among 3"),
        ("x=\"0\"", "x=\"\"", "line 2: x is not the number it should be (in 3D/start.model)"),
        ("<component objectid=\"1\"", "<component objectid=\"2\"", "components of itself"),
        ("objectid=\"7\"", "objectid=\"8\"", "there is no object 8"),
        ("/3D/other.model", "/3D/no.model", "3D/no.model"),
        ("0 1 0 -1", "0 1 0", "twelve numbers"),
    ] {
        let error = fault(from, to);
        assert!(error.contains(what), "{error}");
    }
    assert!(read("3mf", "PK\x03\x04").unwrap_err().contains("no 3MF package"));
    // An object that places another twice, thirty times over.
    let twice = |id: u32| {
        let component = format!("<component objectid=\"{}\"/>", id - 1);
        format!("<object id=\"{id}\"><components>{component}{component}</components></object>")
    };
    let bomb = object(1, "a", PLATE) + &(2..32).map(twice).collect::<String>();
    let bomb = archive(&[("3D/3dmodel.model", &model("", &bomb, "<item objectid=\"31\"/>"))]);
    assert!(read("3mf", bomb).unwrap_err().contains("needs more than"));
    // Numbers that are packed a thousand times smaller than they are.
    let mut zip = ZipWriter::new(Cursor::new(Vec::new()));
    let deflated =
        SimpleFileOptions::default().compression_method(zip::CompressionMethod::Deflated);
    zip.start_file("3D/3dmodel.model", deflated).unwrap();
    (0..80).for_each(|_| zip.write_all(&[b' '; 1_000_000]).unwrap());
    assert!(
        read("3mf", zip.finish().unwrap().into_inner()).unwrap_err().contains("needs more than")
    );
}
