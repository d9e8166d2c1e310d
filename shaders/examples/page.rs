//! Prints a page on which a browser checks all passes and posts what it says: `.ci/tint` serves it.

use pfront_shaders::PASSES;

fn main() {
    // Rust's debug form of a string is a string of JavaScript.
    let passes: Vec<_> =
        PASSES.iter().map(|pass| format!("[{:?}, {:?}]", pass.entry, pass.source())).collect();
    println!(
        r#"<!doctype html><meta charset="utf-8"><script>
const passes = [{}];
(async () => {{
  const report = [];
  try {{
    const adapter = await navigator.gpu.requestAdapter();
    const device = await adapter.requestDevice();
    for (const [name, code] of passes) {{
      const info = await device.createShaderModule({{ code }}).getCompilationInfo();
      for (const message of info.messages)
        if (message.type === "error") report.push(name + ": " + message.message);
    }}
    report.push("checked " + passes.length + " passes");
  }} catch (error) {{
    report.push("failed: " + error);
  }}
  await fetch("/report", {{ method: "POST", body: report.join("\n") }});
}})();
</script>"#,
        passes.join(",\n")
    );
}
