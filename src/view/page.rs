//! The page's own files, built in: nothing is ever read from disk because a request named it.

/// A file of the page by its path: its media type and its bytes.
pub(super) fn file(path: &str) -> Option<(&'static str, &'static [u8])> {
    Some(match path {
        "" => ("text/html; charset=utf-8", include_bytes!("../../web/dist/index.html").as_slice()),
        "view.js" => ("text/javascript; charset=utf-8", include_bytes!("../../web/dist/view.js").as_slice()),
        "view.css" => ("text/css; charset=utf-8", include_bytes!("../../web/dist/view.css").as_slice()),
        _ => return None,
    })
}

/// Headers of every response. The page loads nothing from elsewhere, runs no script but its own, and shows in no frame.
pub(super) const HEADERS: [(&str, &str); 5] = [
    (
        "content-security-policy",
        "default-src 'none'; script-src 'self'; style-src 'self'; img-src 'self' blob: data:; connect-src 'self'; \
         base-uri 'none'; form-action 'none'; frame-ancestors 'none'",
    ),
    ("x-content-type-options", "nosniff"),
    ("referrer-policy", "no-referrer"),
    ("cache-control", "no-store"),
    ("cross-origin-resource-policy", "same-origin"),
];
