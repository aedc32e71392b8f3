//! The page's files, embedded in the binary: no request reads a file that it names from disk.

/// Files of the page: name, media type, bytes.
pub(super) const FILES: [(&str, &str, &[u8]); 3] = [
    ("", "text/html; charset=utf-8", include_bytes!("../../web/dist/index.html")),
    ("view.js", "text/javascript; charset=utf-8", include_bytes!("../../web/dist/view.js")),
    ("view.css", "text/css; charset=utf-8", include_bytes!("../../web/dist/view.css")),
];

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
