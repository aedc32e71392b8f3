//! Who is let in: whoever knows the token, from a page that this server sent, under a name that no stranger's domain can
//! take. All of it is decided from a request's head, before any of its body is read.

use hyper::header::{CONTENT_TYPE, HOST, HeaderMap, HeaderName, ORIGIN};
use hyper::http::request::Parts;
use hyper::{Method, StatusCode};
use std::hint::black_box;
use std::net::{IpAddr, Ipv6Addr};

/// Bytes of a body at most, and of what a browser's GPU computed.
const BODY: u64 = 64 << 10;
const WORDS: u64 = 64 << 20;

/// Why a request isn't answered.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Refusal {
    pub status: StatusCode,
    pub text: &'static str,
}

const fn refusal(status: StatusCode, text: &'static str) -> Refusal {
    Refusal { status, text }
}

const TOKEN: Refusal =
    refusal(StatusCode::FORBIDDEN, "Forbidden: open the whole address that echogrid view printed, token and all.\n");
const NAME: Refusal =
    refusal(StatusCode::FORBIDDEN, "Forbidden: open it by its IP address, or as localhost, not by another name.\n");
const STRANGER: Refusal = refusal(
    StatusCode::FORBIDDEN,
    "Forbidden: another site asked for it. Paste the address into the browser's address bar.\n",
);
const UNKNOWN: Refusal = refusal(StatusCode::NOT_FOUND, "there is nothing at this address");
const METHOD: Refusal = refusal(StatusCode::METHOD_NOT_ALLOWED, "GET, HEAD and POST are answered");
const FORM: Refusal = refusal(StatusCode::UNSUPPORTED_MEDIA_TYPE, "send JSON or bytes, no form");
/// A body that is too large.
pub(super) const LARGE: Refusal = refusal(StatusCode::PAYLOAD_TOO_LARGE, "the body is too large");
/// A body that doesn't come.
pub(super) const SLOW: Refusal = refusal(StatusCode::REQUEST_TIMEOUT, "the body did not come in time");
/// A body that breaks off.
pub(super) const BROKEN: Refusal = refusal(StatusCode::BAD_REQUEST, "the body can't be read");
/// A query that isn't percent-encoded UTF-8.
pub(super) const QUERY: Refusal = refusal(StatusCode::BAD_REQUEST, "the query can't be read");
/// Too much to do.
pub(super) const BUSY: Refusal =
    refusal(StatusCode::SERVICE_UNAVAILABLE, "too many requests are being worked on: ask again");

/// What follows the token in a request's path, without the first slash; `None`: the token alone, without a slash.
pub(super) fn admit(head: &Parts, token: &str) -> Result<Option<String>, Refusal> {
    let host = one(&head.headers, HOST).ok_or(NAME)?;
    let elsewhere = head.uri.authority().is_some_and(|a| !a.as_str().eq_ignore_ascii_case(host));
    if !is_literal(host) || elsewhere {
        return Err(NAME);
    }
    if !is_own_page(&head.headers, host) {
        return Err(STRANGER);
    }
    let path = head.uri.path().strip_prefix('/').ok_or(TOKEN)?;
    let (first, rest) = path.split_once('/').map_or((path, None), |(first, rest)| (first, Some(rest)));
    if !same(first, token) {
        return Err(TOKEN);
    }
    let rest = rest.unwrap_or_default();
    if !is_plain(rest) {
        return Err(UNKNOWN);
    }
    let reads = head.method == Method::GET || head.method == Method::HEAD;
    if !(reads || head.method == Method::POST && rest.starts_with("api/")) {
        return Err(METHOD);
    }
    if head.method == Method::POST && is_form(&head.headers) {
        return Err(FORM);
    }
    Ok(path.contains('/').then(|| rest.to_string()))
}

/// Bytes that a body sent to a path may have.
pub(super) fn limit(path: &str) -> u64 {
    if ["api/gpu/words", "api/gpu/share"].contains(&path) { WORDS } else { BODY }
}

/// Whether a path's bodies may be so large that only few are read at once.
pub(super) fn is_large(path: &str) -> bool {
    limit(path) > BODY
}

/// The only value of a header.
fn one(headers: &HeaderMap, name: HeaderName) -> Option<&str> {
    let mut values = headers.get_all(name).iter();
    let value = values.next()?.to_str().ok()?;
    values.next().is_none().then_some(value)
}

/// Whether a host is an IP address or localhost, with any port: a tunnel has its own. A stranger's domain that is made to
/// resolve to this machine is neither.
fn is_literal(host: &str) -> bool {
    let (name, rest) = match host.strip_prefix('[') {
        Some(rest) => match rest.split_once(']') {
            Some((name, rest)) if name.parse::<Ipv6Addr>().is_ok() => (name, rest),
            _ => return false,
        },
        None => host.find(':').map_or((host, ""), |at| host.split_at(at)),
    };
    let port = rest.is_empty() || rest.strip_prefix(':').is_some_and(|p| p.parse::<u16>().is_ok());
    port && (name.eq_ignore_ascii_case("localhost") || name.parse::<IpAddr>().is_ok())
}

/// Whether a request comes from the page itself or from the address bar, as far as the browser says.
fn is_own_page(headers: &HeaderMap, host: &str) -> bool {
    let own = |origin: &str| {
        let host_of = origin.get(..7).filter(|scheme| scheme.eq_ignore_ascii_case("http://")).map(|_| &origin[7..]);
        host_of.is_some_and(|h| h.eq_ignore_ascii_case(host))
    };
    let origin = !headers.contains_key(ORIGIN) || one(headers, ORIGIN).is_some_and(own);
    let site = HeaderName::from_static("sec-fetch-site");
    let same = !headers.contains_key(&site) || one(headers, site).is_some_and(|s| s == "same-origin" || s == "none");
    origin && same
}

/// Whether two texts are the same, in a time that doesn't tell how much of them is.
fn same(given: &str, token: &str) -> bool {
    let differing = given.bytes().zip(token.bytes()).fold(0, |all, (a, b)| black_box(all | (a ^ b)));
    given.len() == token.len() && differing == 0
}

/// Whether a path is made of plain names: no percent signs, no dots alone, no empty parts.
fn is_plain(path: &str) -> bool {
    let name = |part: &str| {
        !part.is_empty()
            && !part.starts_with('.')
            && part.bytes().all(|b| b.is_ascii_alphanumeric() || b"._-".contains(&b))
    };
    path.is_empty() || path.split('/').all(name)
}

/// Whether a body is of a type that a form on another site could send.
fn is_form(headers: &HeaderMap) -> bool {
    let kind = |value: &hyper::header::HeaderValue| {
        let text = value.to_str().unwrap_or_default().trim_start().to_ascii_lowercase();
        ["text/plain", "multipart/", "application/x-www-form-urlencoded"].iter().any(|form| text.starts_with(form))
    };
    headers.get_all(CONTENT_TYPE).iter().any(kind)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn hosts() {
        for good in ["127.0.0.1", "127.0.0.1:80", "localhost:65535", "LOCALHOST", "[::1]", "[::1]:8000", "10.1.2.3:1"] {
            assert!(is_literal(good), "{good}");
        }
        for bad in [
            "",
            "example.org",
            "localhost.example.org:80",
            "127.0.0.1.nip.io",
            "[::1",
            "[example.org]:80",
            "localhost:x",
            "a@127.0.0.1",
            "127.0.0.1:80:80",
            "localhost:",
            "::1",
            "[127.0.0.1]",
        ] {
            assert!(!is_literal(bad), "{bad}");
        }
    }

    #[test]
    fn paths() {
        for good in ["", "view.js", "api/session", "api/gpu/words"] {
            assert!(is_plain(good), "{good}");
        }
        for bad in ["/", "..", "api/../x", "api//x", "%2e%2e/x", "api/", ".git", "a\0b", "a\\b"] {
            assert!(!is_plain(bad), "{bad}");
        }
    }

    #[test]
    fn tokens() {
        assert!(same("abc", "abc"));
        for bad in ["", "ab", "abcd", "abd"] {
            assert!(!same(bad, "abc"), "{bad}");
        }
    }
}
