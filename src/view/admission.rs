//! Which requests are admitted: those that know the token, come from the server's own page, and name a host that no other site's domain
//! can resolve to. This is decided from the head of a request, before its body is read.

use super::assets;
use super::http_error::{CROSS_SITE, HttpError, TOO_LARGE, WRONG_HOST, WRONG_MEDIA_TYPE, WRONG_TOKEN};
use axum::body::HttpBody;
use axum::extract::{Request, State};
use axum::http::Method;
use axum::http::header::{CONTENT_TYPE, HOST, HeaderMap, HeaderName, HeaderValue, ORIGIN};
use axum::middleware::Next;
use axum::response::IntoResponse;
use std::hint::black_box;
use std::net::{IpAddr, Ipv6Addr};
use std::sync::Arc;

/// Largest body in bytes.
const BODY: usize = 64 << 10;
/// Largest body in bytes of what a browser's GPU computed.
const GPU_BODY: usize = 64 << 20;

/// Middleware that admits a request or rejects it; both responses get the common headers.
pub(super) async fn admission(State(token): State<Arc<str>>, request: Request, next: Next) -> impl IntoResponse {
    let response = match admit(&request, &token) {
        Ok(()) => next.run(request).await,
        Err(error) => error.into_response(),
    };
    (assets::HEADERS, response)
}

fn admit(request: &Request, token: &str) -> Result<(), HttpError> {
    let (uri, headers) = (request.uri(), request.headers());
    let host = single_header(headers, HOST).ok_or(WRONG_HOST)?;
    let elsewhere = uri.authority().is_some_and(|a| !a.as_str().eq_ignore_ascii_case(host));
    if !is_address_or_localhost(host) || elsewhere {
        return Err(WRONG_HOST);
    }
    if !is_same_origin(headers, host) {
        return Err(CROSS_SITE);
    }
    let (given, path) = split_token(uri.path());
    if !is_equal(given, token) {
        return Err(WRONG_TOKEN);
    }
    if request.method() == Method::POST && is_form_media_type(headers) {
        return Err(WRONG_MEDIA_TYPE);
    }
    if request.body().size_hint().lower() > body_limit(path) as u64 {
        return Err(TOO_LARGE);
    }
    Ok(())
}

/// Splits a path into its first segment, the token, and what follows the slash behind it.
pub(super) fn split_token(path: &str) -> (&str, &str) {
    let path = path.strip_prefix('/').unwrap_or_default();
    path.split_once('/').unwrap_or((path, ""))
}

/// The largest body of a path, bytes.
pub(super) fn body_limit(path: &str) -> usize {
    if ["api/gpu/words", "api/gpu/share"].contains(&path) { GPU_BODY } else { BODY }
}

/// Whether a path takes bodies so large that only few are read at once.
pub(super) fn is_large(path: &str) -> bool {
    body_limit(path) > BODY
}

/// The value of a header that is present once.
fn single_header(headers: &HeaderMap, name: HeaderName) -> Option<&str> {
    let mut values = headers.get_all(name).iter();
    let value = values.next()?.to_str().ok()?;
    values.next().is_none().then_some(value)
}

/// Whether a host is an IP address or localhost, with any port: a tunnel has its own. Another site's domain that resolves to this
/// machine (DNS rebinding) is neither.
fn is_address_or_localhost(host: &str) -> bool {
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

/// Whether the browser says that a request comes from the page itself or from the address bar.
fn is_same_origin(headers: &HeaderMap, host: &str) -> bool {
    let own = |origin: &str| {
        let host_of = origin.get(..7).filter(|scheme| scheme.eq_ignore_ascii_case("http://")).map(|_| &origin[7..]);
        host_of.is_some_and(|h| h.eq_ignore_ascii_case(host))
    };
    let origin = !headers.contains_key(ORIGIN) || single_header(headers, ORIGIN).is_some_and(own);
    let site = HeaderName::from_static("sec-fetch-site");
    let same =
        !headers.contains_key(&site) || single_header(headers, site).is_some_and(|s| s == "same-origin" || s == "none");
    origin && same
}

/// Whether two texts are equal, in a time that does not depend on where they differ.
fn is_equal(given: &str, token: &str) -> bool {
    let differing = given.bytes().zip(token.bytes()).fold(0, |all, (a, b)| black_box(all | (a ^ b)));
    given.len() == token.len() && differing == 0
}

/// Whether the media type is one that a form on another site could send.
fn is_form_media_type(headers: &HeaderMap) -> bool {
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
            assert!(is_address_or_localhost(good), "{good}");
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
            assert!(!is_address_or_localhost(bad), "{bad}");
        }
    }

    #[test]
    fn tokens() {
        assert!(is_equal("abc", "abc"));
        for bad in ["", "ab", "abcd", "abd"] {
            assert!(!is_equal(bad, "abc"), "{bad}");
        }
    }
}
