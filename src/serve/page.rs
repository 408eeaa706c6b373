//! The page: one file, built from `page/` (`npm run build` there) and embedded.

use axum::http::header;
use axum::response::{IntoResponse, Response};

/// The page with its style and its program in it.
pub const PAGE: &str = include_str!("../../page/dist/index.html");

/// `GET /?token=…`.
pub async fn page() -> Response {
    // Nothing from elsewhere; the program itself is in the page.
    const POLICY: &str = "default-src 'none'; script-src 'unsafe-inline'; style-src 'unsafe-inline'; img-src blob: data:; \
                          worker-src blob:; connect-src 'self'; base-uri 'none'; form-action 'none'; frame-ancestors 'none'";
    let headers =
        [(header::CONTENT_TYPE, "text/html; charset=utf-8"), (header::CONTENT_SECURITY_POLICY, POLICY)];
    (headers, PAGE).into_response()
}
