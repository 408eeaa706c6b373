//! What goes over the wire: JSON, or JSON with binary blocks behind it.
//!
//! A binary answer: the length of the head (u32), the head (JSON, padded with spaces so that what follows is aligned to
//! 8 bytes), then the blocks one after the other. Little-endian. The head says how long each block is.

use std::sync::Arc;

use axum::body::Bytes;
use axum::http::{StatusCode, header};
use axum::response::{IntoResponse, Response};
use serde_json::{Map, Value, json};

use super::app::App;
use crate::error::Error;
use crate::geometry::{Pose2, Vec2};

/// A refusal: a status, and a line for the person.
#[derive(Debug)]
pub struct Fault {
    status: StatusCode,
    message: String,
}

impl Fault {
    /// A refusal.
    pub fn new(status: StatusCode, message: impl Into<String>) -> Self {
        Fault { status, message: message.into() }
    }

    /// Something in the request is not as it should be.
    pub fn bad(message: impl Into<String>) -> Self {
        Fault::new(StatusCode::BAD_REQUEST, message)
    }

    /// What was asked is about a map that is no longer on screen.
    pub fn outdated() -> Self {
        Fault::new(StatusCode::CONFLICT, "the map has changed meanwhile: look again")
    }

    /// There is no map yet.
    pub fn nothing_open() -> Self {
        Fault::new(StatusCode::CONFLICT, "no map is open")
    }
}

impl From<Error> for Fault {
    fn from(error: Error) -> Self {
        let status = match error {
            Error::Input { .. } => StatusCode::UNPROCESSABLE_ENTITY,
            _ => StatusCode::INTERNAL_SERVER_ERROR,
        };
        Fault::new(status, error.to_string())
    }
}

impl IntoResponse for Fault {
    fn into_response(self) -> Response {
        (self.status, answer(&json!({"error": self.message}))).into_response()
    }
}

/// The answer to a request.
pub type Answer = std::result::Result<Response, Fault>;

/// Runs what computes or waits for the disk beside the requests, a few at a time.
///
/// # Errors
/// What `work` says.
pub async fn aside(app: Arc<App>, work: impl FnOnce(&App) -> Answer + Send + 'static) -> Answer {
    let ended = tokio::task::spawn_blocking(move || work(&app)).await;
    ended.unwrap_or_else(|e| Err(Fault::new(StatusCode::INTERNAL_SERVER_ERROR, e.to_string())))
}

/// JSON.
pub fn answer(value: &Value) -> Response {
    ([(header::CONTENT_TYPE, "application/json")], value.to_string()).into_response()
}

/// The object in a request's body.
///
/// # Errors
/// [`Fault`] if it is none.
pub fn object(body: &Bytes) -> std::result::Result<Map<String, Value>, Fault> {
    match serde_json::from_slice(body) {
        Ok(Value::Object(object)) => Ok(object),
        Ok(_) => Err(Fault::bad("found no JSON object in the request, expected one")),
        Err(e) => Err(Fault::bad(format!("found a request that is not JSON ({e}), expected an object"))),
    }
}

/// JSON with blocks of bytes behind it; each block is padded to 8 bytes.
pub fn packed(head: &Value, blocks: &[&[u8]]) -> Response {
    let mut text = head.to_string();
    while !(text.len() + 4).is_multiple_of(8) {
        text.push(' ');
    }
    let mut bytes = Vec::with_capacity(4 + text.len() + blocks.iter().map(|b| b.len() + 8).sum::<usize>());
    bytes.extend_from_slice(&(text.len() as u32).to_le_bytes());
    bytes.extend_from_slice(text.as_bytes());
    for block in blocks {
        bytes.extend_from_slice(block);
        bytes.resize(bytes.len().next_multiple_of(8), 0);
    }
    ([(header::CONTENT_TYPE, "application/octet-stream")], bytes).into_response()
}

/// Poses as they go over the wire: x, y, θ as f64.
pub fn pose_bytes(poses: &[Pose2], world_from_map: Pose2) -> Vec<u8> {
    let turned = poses.iter().flat_map(|p| world_from_map.compose(*p).to_array());
    turned.flat_map(f64::to_le_bytes).collect()
}

/// Two points.
pub fn ends_json(ends: [Vec2; 2]) -> Value {
    json!([[ends[0].x, ends[0].y], [ends[1].x, ends[1].y]])
}
