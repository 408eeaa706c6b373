//! Who may ask: this computer's own pages that know the token. A page of another site in the same browser may not
//! (`Origin`), nor one whose name was made to point here (`Host`, DNS rebinding).

use std::fmt::Write as _;
use std::sync::Arc;

use axum::extract::{Request, State};
use axum::http::{HeaderMap, HeaderValue, StatusCode, header};
use axum::middleware::Next;
use axum::response::{IntoResponse, Response};

use super::app::App;
use super::wire::Fault;
use crate::error::{Error, Result};

/// Carries the token in every request of the page.
pub const TOKEN: &str = "x-hitl-token";

/// 128 random bits, hexadecimal.
///
/// # Errors
/// [`Error::Internal`] if the system has no random numbers.
pub fn new_token() -> Result<String> {
    let mut bytes = [0; 16];
    getrandom::fill(&mut bytes).map_err(|e| Error::Internal(e.to_string()))?;
    let mut token = String::with_capacity(32);
    for byte in bytes {
        // Writing to a string cannot fail.
        let _ = write!(token, "{byte:02x}");
    }
    Ok(token)
}

/// Refuses what may not ask.
pub async fn check(State(app): State<Arc<App>>, request: Request, next: Next) -> Response {
    if let Err(reason) = allowed(&app.token, &request) {
        return Fault::new(StatusCode::FORBIDDEN, reason).into_response();
    }
    let mut response = next.run(request).await;
    let headers = response.headers_mut();
    headers.insert(header::CACHE_CONTROL, HeaderValue::from_static("no-store"));
    headers.insert(header::X_CONTENT_TYPE_OPTIONS, HeaderValue::from_static("nosniff"));
    headers.insert(header::REFERRER_POLICY, HeaderValue::from_static("no-referrer"));
    response
}

fn allowed(token: &str, request: &Request) -> std::result::Result<(), &'static str> {
    let headers = request.headers();
    let host = text(headers, "host").ok_or("no Host")?;
    if !is_loopback(host) {
        return Err("this Host is not allowed");
    }
    match text(headers, "origin").map(|o| o.strip_prefix("http://")) {
        None => {}
        Some(Some(origin)) if origin == host => {}
        Some(_) => return Err("this Origin is not allowed"),
    }
    let in_address = || {
        let query = request.uri().query().unwrap_or_default();
        query.split('&').find_map(|pair| pair.strip_prefix("token="))
    };
    let given = match request.uri().path() {
        "/" => in_address(),
        _ => text(headers, TOKEN),
    };
    match given {
        Some(given) if is_same(given.as_bytes(), token.as_bytes()) => Ok(()),
        _ => Err("open the address that `hitl serve` printed: it holds the token"),
    }
}

fn text<'a>(headers: &'a HeaderMap, name: &str) -> Option<&'a str> {
    headers.get(name).and_then(|v| v.to_str().ok())
}

/// Any port: whoever comes through a tunnel sees another one.
fn is_loopback(host: &str) -> bool {
    let name = match host.rsplit_once(':') {
        Some((name, port)) if port.bytes().all(|b| b.is_ascii_digit()) => name,
        _ => host,
    };
    ["127.0.0.1", "localhost", "[::1]"].contains(&name)
}

/// In a time that does not depend on where they differ.
fn is_same(a: &[u8], b: &[u8]) -> bool {
    a.len() == b.len() && a.iter().zip(b).fold(0, |sum, (x, y)| sum | (x ^ y)) == 0
}
