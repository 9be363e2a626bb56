//! Access control. Three kinds of request are refused: from another page in the same browser, from another user of the
//! machine, and under a name that was made to point to the loopback address (DNS rebinding).

use std::sync::{Arc, Mutex, PoisonError};

use axum::extract::{Request, State};
use axum::http::header::{
    CACHE_CONTROL, CONTENT_SECURITY_POLICY, COOKIE, HOST, ORIGIN, REFERRER_POLICY, UPGRADE,
    X_CONTENT_TYPE_OPTIONS, X_FRAME_OPTIONS,
};
use axum::http::{HeaderMap, HeaderName, HeaderValue, Method, StatusCode};
use axum::middleware::Next;
use axum::response::{IntoResponse, Response};

/// The address where a key is exchanged for the cookie; the only one that needs no cookie.
pub const ENTER: &str = "/enter";

/// The content security policy: the page may load only itself. Plotly writes its style rules into the page.
const POLICY: &str = "default-src 'none'; script-src 'self'; style-src 'self' 'unsafe-inline'; \
    img-src 'self' data: blob:; connect-src 'self'; form-action 'self'; base-uri 'none'; \
    frame-ancestors 'none'";

/// The keys of one run of the lab.
pub struct Guard {
    port: u16,
    /// The key in the owner's file.
    door_key: String,
    /// The key in the address that opens the page once.
    once_key: Mutex<Option<String>>,
    /// The key in the cookie.
    cookie_key: String,
}

impl Guard {
    /// New keys.
    pub fn new(port: u16) -> Guard {
        Guard {
            port,
            door_key: key(),
            once_key: Mutex::new(Some(key())),
            cookie_key: key(),
        }
    }

    /// The address of the page.
    pub fn address(&self) -> String {
        format!("http://127.0.0.1:{}", self.port)
    }

    /// The key for the file of the owner.
    pub fn door_key(&self) -> &str {
        &self.door_key
    }

    /// The address with the one-time key; the page's plain address after that key was used.
    pub fn one_time_address(&self) -> String {
        let once = self.once_key.lock().unwrap_or_else(PoisonError::into_inner);
        match once.as_deref() {
            Some(once) => format!("{}{ENTER}?key={once}", self.address()),
            None => self.address(),
        }
    }

    /// The cookie in exchange for a key.
    pub fn exchange(&self, given: &str) -> Option<HeaderValue> {
        let mut once = self.once_key.lock().unwrap_or_else(PoisonError::into_inner);
        let is_once = once.as_deref().is_some_and(|once| same(once, given));
        if is_once {
            *once = None;
        }
        if !is_once && !same(&self.door_key, given) {
            return None;
        }
        // Browsers share cookies between the ports of a host; the name distinguishes two labs.
        let cookie = format!(
            "{}={}; Path=/; HttpOnly; SameSite=Strict",
            self.cookie_name(),
            self.cookie_key
        );
        HeaderValue::from_str(&cookie).ok()
    }

    fn cookie_name(&self) -> String {
        format!("flywheel-lab-{}", self.port)
    }

    /// Whether a Host header names this server. Browsers leave out the port 80.
    fn is_own_host(&self, host: &str) -> bool {
        let port = match host.rsplit_once(':') {
            Some((_, port)) => port.parse().ok(),
            None => Some(80),
        };
        let name = host.split(':').next();
        matches!(name, Some("127.0.0.1" | "localhost")) && port == Some(self.port)
    }

    /// The reason to refuse a request, if there is one.
    fn refusal(&self, method: &Method, path: &str, headers: &HeaderMap) -> Option<&'static str> {
        let text = |name: HeaderName| headers.get(name).and_then(|value| value.to_str().ok());
        let host = text(HOST).unwrap_or_default();
        if !self.is_own_host(host) {
            return Some("this is not the host of the lab");
        }
        if path == ENTER {
            // The request comes from the owner's file, which has no origin; the key decides.
            return None;
        }
        let origin = text(ORIGIN);
        let own_origin = origin.is_some_and(|origin| origin == format!("http://{host}"));
        let changes =
            !matches!(*method, Method::GET | Method::HEAD) || headers.contains_key(UPGRADE);
        if (headers.contains_key(ORIGIN) || changes) && !own_origin {
            return Some("the request comes from another page");
        }
        let name = self.cookie_name();
        let cookies = headers.get_all(COOKIE).iter();
        let mut cookies = cookies.filter_map(|value| value.to_str().ok());
        let known = cookies.any(|line| {
            line.split(';')
                .filter_map(|pair| pair.trim().split_once('='))
                .any(|(found, value)| found == name && same(value, &self.cookie_key))
        });
        (!known).then_some(
            "this browser has not been let in: open the lab by the file or the address that `flywheel lab` printed",
        )
    }
}

/// Passes on permitted requests, and adds headers to every answer that keep other pages out.
pub async fn guarded(State(guard): State<Arc<Guard>>, request: Request, next: Next) -> Response {
    let refusal = guard.refusal(request.method(), request.uri().path(), request.headers());
    let mut response = match refusal {
        Some(reason) => (StatusCode::FORBIDDEN, format!("{reason}\n")).into_response(),
        None => next.run(request).await,
    };
    let headers = response.headers_mut();
    for (name, value) in [
        (CONTENT_SECURITY_POLICY, POLICY),
        (X_CONTENT_TYPE_OPTIONS, "nosniff"),
        (X_FRAME_OPTIONS, "DENY"),
        (REFERRER_POLICY, "no-referrer"),
        (CACHE_CONTROL, "no-store"),
        (
            HeaderName::from_static("cross-origin-resource-policy"),
            "same-origin",
        ),
        (
            HeaderName::from_static("cross-origin-opener-policy"),
            "same-origin",
        ),
    ] {
        headers
            .entry(name)
            .or_insert(HeaderValue::from_static(value));
    }
    response
}

/// 256 random bits.
fn key() -> String {
    let bytes: [u8; 32] = rand::random();
    bytes.iter().map(|byte| format!("{byte:02x}")).collect()
}

/// Whether two texts are equal, in constant time.
fn same(one: &str, other: &str) -> bool {
    let differing = one
        .bytes()
        .zip(other.bytes())
        .fold(0, |bits, (a, b)| bits | (a ^ b));
    one.len() == other.len() && differing == 0
}
