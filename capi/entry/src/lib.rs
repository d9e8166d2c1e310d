//! The attribute of the functions that pfront exports to C.

use proc_macro::{Delimiter, Group, TokenStream, TokenTree};

/// Exports a function to C under its name.
///
/// `fn name(call: &mut Call<'_>, ...) -> Done` gets one more parameter in C, `error`, and returns a status: what the function
/// returns, told by `Caller::call`, which also sets the floating-point environment and stops panics. Any other function, which
/// then must be safe whatever it is given, is exported as it stands. `tests/header.rs` reads both from the sources.
#[proc_macro_attribute]
pub fn entry(_: TokenStream, item: TokenStream) -> TokenStream {
    let mut head: Vec<TokenTree> = item.into_iter().collect();
    let body = head.pop();
    let is_fallible = head.last().is_some_and(|token| token.to_string() == "Done");
    let at = head.iter().position(|token| token.to_string() == "fn").unwrap_or(0);
    let mut rest = head.split_off(at);
    let exported =
        "#[unsafe(no_mangle)] #[expect(unsafe_code, reason = \"C finds functions by name\")] pub";
    if !is_fallible {
        return [stream(head), code(exported), code("extern \"C\""), stream(rest), stream(body)]
            .into_iter()
            .collect();
    }
    let done = rest.split_off(rest.len() - 3);
    let Some(TokenTree::Group(parameters)) = rest.pop() else {
        return code("compile_error!(\"no parameters\");");
    };
    let mut call: Vec<_> = parameters.stream().into_iter().collect();
    let is_comma = |token: &TokenTree| token.to_string() == ",";
    let mut in_c = call.split_off(call.iter().position(is_comma).unwrap_or(call.len()));
    in_c.pop_if(|token| is_comma(token));
    let in_c = [stream(in_c.into_iter().skip(1)), code(", error: *mut crate::pfront_error_t")];
    // The caller of a function that has `error` keeps to the contract of the header, which is that of `Caller::trusted`.
    let body = [
        code("#[deny(unsafe_code)] let body = |"),
        stream(call),
        code("|"),
        stream(done),
        stream(body),
        code("; unsafe { crate::memory::Caller::trusted() }.call(error, body)"),
    ];
    [
        stream(head),
        code("#[expect(clippy::missing_safety_doc, reason = \"the header has the contract, once for all functions\")]"),
        code(exported),
        code("unsafe extern \"C\""),
        stream(rest),
        stream([group(Delimiter::Parenthesis, in_c)]),
        code("-> crate::pfront_status_t"),
        stream([group(Delimiter::Brace, body)]),
    ]
    .into_iter()
    .collect()
}

fn group(delimiter: Delimiter, parts: impl IntoIterator<Item = TokenStream>) -> TokenTree {
    Group::new(delimiter, parts.into_iter().collect()).into()
}

fn stream(tokens: impl IntoIterator<Item = TokenTree>) -> TokenStream {
    tokens.into_iter().collect()
}

/// Rust as text, seen by the compiler as if it stood where the attribute does.
#[expect(clippy::expect_used, reason = "it is text of this file")]
fn code(text: &str) -> TokenStream {
    text.parse().expect("Rust")
}
