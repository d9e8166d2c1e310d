//! Writes the JavaScript and the types around a compiled module. Arguments: the module, a folder, and a name for what is written.

use std::error::Error;
use std::path::Path;
use wasm_bindgen_cli_support::Bindgen;

fn main() -> Result<(), Box<dyn Error>> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let [module, folder, name] = &arguments[..] else {
        return Err("arguments: MODULE FOLDER NAME".into());
    };
    let mut bindgen = Bindgen::new();
    bindgen.input_path(Path::new(module)).out_name(name).web(true)?.typescript(true);
    Ok(bindgen.generate(folder)?)
}
