//! Pages of reports, for the tests of every program.

/// Asserts that a page loads only its own style and pictures.
pub fn loads_nothing(page: &str) {
    let head = &page[..page.find("</head>").unwrap()];
    assert!(head.contains("http-equiv=\"Content-Security-Policy\" content=\"default-src 'none'; "));
    assert!(!page.contains("<script") && !page.contains("href=\"http"));
}
