//! Packages of 3MF that ask for more than they have, and some that are read with a note.

use super::bodies::{PIN, PLATE, archive, model, object, three_mf};
use super::lenient::read;
use pfront_files::{ReadOptions, read_bytes};
use std::io::{Cursor, Write};
use zip::ZipWriter;
use zip::write::SimpleFileOptions;

const START: &str = "3D/3dmodel.model";
const ITEM: &str = "<item objectid=\"1\"/>";

fn package(resources: &str, items: &str) -> Vec<u8> {
    archive(&[(START, &model("", resources, items))])
}

fn refused(bytes: Vec<u8>, what: &str) {
    let error = read("3mf", bytes).unwrap_err();
    assert!(error.contains(what), "{error}");
}

#[test]
fn parts_do_not_overlap() {
    let mut zip = ZipWriter::new(Cursor::new(Vec::new()));
    zip.start_file(START, SimpleFileOptions::default()).unwrap();
    zip.write_all(model("", &object(1, "plate", PLATE), ITEM).as_bytes()).unwrap();
    zip.shallow_copy_file(START, "3D/copy.model").unwrap();
    refused(zip.finish().unwrap().into_inner(), "overlap");
    // The directory says that a part is packed into 2^28 bytes.
    let mut bytes = three_mf();
    let directory = bytes.windows(4).position(|window| window == b"PK\x01\x02").unwrap();
    bytes[directory + 20..][..4].copy_from_slice(&(1_u32 << 28).to_le_bytes());
    refused(bytes, "overlap");
}

#[test]
fn components_are_as_deep_as_they_like_but_not_in_circles() {
    let holder = |id: u32, held: u32| {
        format!(
            "<object id=\"{id}\"><components><component objectid=\"{held}\" transform=\"1 0 0 0 1 0 0 0 1 0 0 1\"/></components></object>"
        )
    };
    let deep: String = (2..=3000).map(|id| holder(id, id - 1)).collect();
    let deep = object(1, "plate", PLATE) + &deep;
    let file = read("3mf", package(&deep, "<item objectid=\"3000\"/>")).unwrap();
    assert_eq!(file.mesh.positions[0], [0.0, 0.0, 2999.0]);
    let circle = holder(1, 2) + &holder(2, 3) + &holder(3, 2);
    refused(package(&circle, ITEM), "object 2 has components of itself");
    // The same object twice is no circle.
    let twice = "<component objectid=\"1\"/>".repeat(2);
    let twice = format!("<object id=\"2\"><components>{twice}</components></object>");
    let twice = object(1, "plate", PLATE) + &twice;
    let file = read("3mf", package(&twice, "<item objectid=\"2\"/>")).unwrap();
    assert_eq!(file.mesh.triangles.len(), 2);
}

#[test]
fn objects_take_of_the_budget() {
    let objects: String = (2..100_000).map(|id| format!("<object id=\"{id}\"/>")).collect();
    let bytes = package(&(object(1, "plate", PLATE) + &objects), ITEM);
    let read = |memory| {
        let format = Some("3mf".to_owned());
        read_bytes(&bytes, &ReadOptions { format, memory: Some(memory), ..ReadOptions::default() })
    };
    assert!(read(8_000_000).unwrap_err().to_string().contains("needs more than"));
    assert!(read(80_000_000).is_ok());
}

#[test]
fn the_production_extension_has_any_prefix() {
    let space = |prefix: &str| {
        format!(
            "xmlns:{prefix}=\"http://schemas.microsoft.com/3dmanufacturing/production/2015/06\" requiredextensions=\"{prefix}\""
        )
    };
    let other = model("", &object(7, "pin", PIN), "");
    let parts = |item: &str| {
        let start = model(&space("prod"), "", item);
        archive(&[(START, &start), ("3D/other.model", &other)])
    };
    let file = read("3mf", parts("<item objectid=\"7\" prod:path=\"/3D/other.model\"/>")).unwrap();
    assert_eq!(file.source.bodies(), ["pin"]);
    refused(parts("<item objectid=\"7\" a:path=\"/3D/a\" b:path=\"/3D/other.model\"/>"), "a path");
}

#[test]
fn packages_are_read_as_programs_write_them() {
    let good = read("3mf", three_mf()).unwrap();
    let [x, y, z] = [2.0, 0.0, 5.0];
    let moved = PIN.map(|p| [p[0] - x, p[1] - y, p[2] - z]);
    let resources = object(1, "plate", PLATE) + &object(2, "pin", moved);
    let items = format!("{ITEM}<item objectid=\"2\" transform=\"1 0 0 0 1 0 0 0 1 {x} {y} {z}\"/>");
    let text = model("", &resources, &items);
    // As Python writes namespaces.
    let prefixed = text.replace("</", "</@").replace('<', "<n:").replace("<n:/@", "</n:");
    let prefixed = prefixed.replace("<n:?", "<?").replace("xmlns=", "xmlns:n=");
    for (name, text) in [
        (START, prefixed),
        (START, format!("\u{feff}{text}")),
        ("3D/3DModel.model", text.clone()),
        (START, text.replace("<resources>", "<resources><!-- <object id=\"1\"/> -->")),
    ] {
        let file = read("3mf", archive(&[(name, &text)])).unwrap_or_else(|e| panic!("{text}: {e}"));
        assert_eq!(
            (&file.mesh, file.source.bodies()),
            (&good.mesh, good.source.bodies()),
            "{text}"
        );
    }
    // Elements of another namespace are none of the core.
    let other =
        text.replace("<triangle v1", "<t:triangle v1=\"0\" v2=\"0\" v3=\"0\"/><triangle v1");
    assert_eq!(read("3mf", archive(&[(START, &other)])).unwrap().mesh, good.mesh);
}

#[test]
fn units_are_noted_and_not_mixed() {
    let start = |unit: &str, item: &str| {
        model("", &object(1, "plate", PLATE), item)
            .replace("unit=\"millimeter\"", &format!("unit=\"{unit}\""))
    };
    let plain = read("3mf", archive(&[(START, &start("millimeter", ITEM))])).unwrap();
    assert!(plain.notes.is_empty());
    let inch = read("3mf", archive(&[(START, &start("inch", ITEM))])).unwrap();
    assert_eq!(inch.notes, ["the unit is 'inch': coordinates stay as written"]);
    assert_eq!(inch.mesh, plain.mesh);
    let beside = ITEM.to_owned() + "<item objectid=\"1\" p:path=\"/3D/other.model\"/>";
    let parts = [start("inch", &beside), start("meter", "")];
    let parts = archive(&[(START, &parts[0]), ("3D/other.model", &parts[1])]);
    refused(parts, "3D/other.model: the unit is 'meter', not 'inch'");
}

#[test]
fn objects_have_their_own_numbers_and_an_end() {
    let (plate, pin) = (object(1, "plate", PLATE), object(1, "pin", PIN));
    refused(package(&(plate.clone() + &pin), ITEM), "there are two objects 1");
    let within = plate.replace("</object>", "<object id=\"2\"/></object>");
    refused(package(&within, ITEM), "object 1 has another object in it");
    let start = model("", &plate, ITEM);
    let cut = &start[..start.find("</object>").unwrap()];
    refused(archive(&[(START, cut)]), "object 1 has no end");
}

#[test]
fn items_without_triangles_are_noted() {
    let objects = object(1, "plate", PLATE) + "<object id=\"2\" name=\"air\"/>";
    let items = ITEM.to_owned() + &"<item objectid=\"2\"/>".repeat(2);
    let file = read("3mf", package(&objects, &items)).unwrap();
    assert_eq!(file.notes, ["items without triangles: 2, the first of them air"]);
    assert_eq!(file.source.bodies(), ["plate"]);
}
