//! Text in XML, for every report that writes it.

/// Whether XML 1.0 allows the character.
pub fn is_xml(c: char) -> bool {
    matches!(c, '\t' | '\n' | '\r' | '\u{20}'..='\u{d7ff}' | '\u{e000}'..='\u{fffd}' | '\u{10000}'..)
}

/// Text as the value of an attribute or of an element: markup and line ends as references, what XML 1.0 cannot hold as U+FFFD.
pub fn escape(text: &str) -> String {
    let mut out = String::with_capacity(text.len());
    for c in text.chars() {
        match c {
            '&' => out.push_str("&amp;"),
            '<' => out.push_str("&lt;"),
            '>' => out.push_str("&gt;"),
            '"' => out.push_str("&quot;"),
            '\'' => out.push_str("&apos;"),
            '\n' | '\t' | '\r' => out.push_str(&format!("&#{};", c as u32)),
            c if is_xml(c) => out.push(c),
            // What XML cannot say at all.
            _ => out.push('\u{fffd}'),
        }
    }
    out
}
