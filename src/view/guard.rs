//! Who is let in: whoever knows the token, from a page that this server sent, under a name that no stranger's domain can
//! take. All of it is decided from a request's head, before any of its body is read.

use super::page;
use super::refusal::{FORM, LARGE, NAME, Refusal, STRANGER, TOKEN};
use axum::body::HttpBody;
use axum::extract::{Request, State};
use axum::http::Method;
use axum::http::header::{CONTENT_TYPE, HOST, HeaderMap, HeaderName, HeaderValue, ORIGIN};
use axum::middleware::Next;
use axum::response::IntoResponse;
use std::hint::black_box;
use std::net::{IpAddr, Ipv6Addr};
use std::sync::Arc;

/// Bytes of a body at most, and of what a browser's GPU computed.
const BODY: usize = 64 << 10;
const WORDS: usize = 64 << 20;

/// Lets a request in or turns it away; either way the response has the headers that all have.
pub(super) async fn guard(State(token): State<Arc<str>>, request: Request, next: Next) -> impl IntoResponse {
    let reply = match admit(&request, &token) {
        Ok(()) => next.run(request).await,
        Err(refusal) => refusal.into_response(),
    };
    (page::HEADERS, reply)
}

fn admit(request: &Request, token: &str) -> Result<(), Refusal> {
    let (uri, headers) = (request.uri(), request.headers());
    let host = one(headers, HOST).ok_or(NAME)?;
    let elsewhere = uri.authority().is_some_and(|a| !a.as_str().eq_ignore_ascii_case(host));
    if !is_literal(host) || elsewhere {
        return Err(NAME);
    }
    if !is_own_page(headers, host) {
        return Err(STRANGER);
    }
    let (given, path) = parts(uri.path());
    if !same(given, token) {
        return Err(TOKEN);
    }
    if request.method() == Method::POST && is_form(headers) {
        return Err(FORM);
    }
    if request.body().size_hint().lower() > limit(path) as u64 {
        return Err(LARGE);
    }
    Ok(())
}

/// A path's first part, the token, and what follows the slash behind it.
pub(super) fn parts(path: &str) -> (&str, &str) {
    let path = path.strip_prefix('/').unwrap_or_default();
    path.split_once('/').unwrap_or((path, ""))
}

/// Bytes that a body sent to a path may have.
pub(super) fn limit(path: &str) -> usize {
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

/// Whether a body is of a type that a form on another site could send.
fn is_form(headers: &HeaderMap) -> bool {
    let kind = |value: &HeaderValue| {
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
    fn tokens() {
        assert!(same("abc", "abc"));
        for bad in ["", "ab", "abcd", "abd"] {
            assert!(!same(bad, "abc"), "{bad}");
        }
    }
}
