//! The addresses of the server.

use axum::body::Bytes;
use axum::extract::{DefaultBodyLimit, Form, Path, Query, State};
use axum::http::StatusCode;
use axum::http::header::{CONTENT_DISPOSITION, CONTENT_TYPE, SET_COOKIE};
use axum::response::{Html, IntoResponse, Response};
use axum::routing::{get, post};
use axum::{Json, Router, middleware};
use data_check::Corrections;
use serde::Deserialize;
use serde_json::{Value, json};
use workbench::ExportLanguage;

use crate::design_facts::{self, Asked};
use crate::desk::said;
use crate::guard::{ENTER, guarded};
use crate::report_findings::ReportFindings;
use crate::shared::Shared;
use crate::work::{self, LabTask};
use crate::{assets, facts, folder, help, socket};

/// Largest body of a request, bytes. The page sends names and numbers only.
const LARGEST_BODY: usize = 256 * 1024;

/// Largest file that can be dropped, bytes; 100 000 samples of ten columns take a tenth of it.
const LARGEST_FILE: usize = 64 * 1024 * 1024;

/// All addresses, behind the access control.
pub fn router(shared: Shared) -> Router {
    Router::new()
        .route("/", get(async || asset("index.html")))
        .route(ENTER, get(enter_once).post(enter))
        .route(
            "/assets/{name}",
            get(async |Path(name): Path<String>| asset(&name)),
        )
        .route("/assets/plotly.js", get(async || assets::plot_library()))
        .route("/help", get(help::first))
        .route("/help/{*path}", get(help::file))
        .route("/api/state", get(state))
        .route("/api/benches", get(benches))
        .route("/api/effects", get(async || Json(facts::effects())))
        .route("/api/diagnosis", get(diagnosis))
        .route("/api/work", post(begin).delete(call_off))
        .route("/api/design", post(design))
        .route("/api/controller", get(controller))
        .route("/api/drop/check", post(check_text))
        .route("/api/effect/check", post(check_effect))
        .route("/api/drop/correct", post(correct))
        .route("/api/export/{language}", get(export))
        .route("/api/report", get(report))
        .route("/socket", get(socket::upgrade))
        .layer(DefaultBodyLimit::max(LARGEST_BODY))
        // This route is added after the layer with the common limit, so that it has a limit of its own.
        .route(
            "/api/drop",
            get(dropped)
                .post(drop_file)
                .delete(forget)
                .layer(DefaultBodyLimit::max(LARGEST_FILE)),
        )
        .layer(middleware::from_fn_with_state(
            shared.guard.clone(),
            guarded,
        ))
        .with_state(shared)
}

/// The answer to a refused request, as the page shows it.
fn refused(status: StatusCode, message: impl Into<String>) -> Response {
    (status, Json(json!({"message": message.into()}))).into_response()
}

fn no_bench() -> Response {
    refused(StatusCode::CONFLICT, "no bench is open")
}

fn asset(name: &str) -> Response {
    assets::file(name).unwrap_or_else(|| StatusCode::NOT_FOUND.into_response())
}

#[derive(Deserialize)]
struct Key {
    key: String,
}

async fn enter(State(shared): State<Shared>, Form(given): Form<Key>) -> Response {
    let_in(&shared, &given.key)
}

async fn enter_once(State(shared): State<Shared>, Query(given): Query<Key>) -> Response {
    let_in(&shared, &given.key)
}

/// Sets the cookie for a key, and returns a page that redirects. A browser that another page had redirected would not
/// send the cookie.
fn let_in(shared: &Shared, key: &str) -> Response {
    match shared.guard.exchange(key) {
        Some(cookie) => (
            [(SET_COOKIE, cookie)],
            Html("<!doctype html><meta charset=\"utf-8\"><meta http-equiv=\"refresh\" content=\"0;url=/\"><link rel=\"icon\" href=\"data:,\"><title>flywheel lab</title><a href=\"/\">To the lab</a>"),
        )
            .into_response(),
        None => (
            StatusCode::FORBIDDEN,
            "this key does not open the lab (any more): start it again\n",
        )
            .into_response(),
    }
}

async fn state(State(shared): State<Shared>) -> Response {
    computed(move || Ok(facts::state(&shared.desk))).await
}

async fn benches() -> Response {
    computed(|| {
        let found = folder::nearby();
        let found = found.iter().map(|path| path.display().to_string());
        Ok(json!(found.collect::<Vec<_>>()))
    })
    .await
}

async fn diagnosis(State(shared): State<Shared>) -> Response {
    computed(move || {
        let bench = shared.desk.bench();
        Ok(bench.map_or(Value::Null, |bench| facts::diagnosis(&bench)))
    })
    .await
}

async fn begin(State(shared): State<Shared>, Json(task): Json<LabTask>) -> Response {
    match work::start(&shared.desk, task) {
        Ok(number) => (StatusCode::ACCEPTED, Json(json!({"number": number}))).into_response(),
        Err(message) => refused(StatusCode::CONFLICT, message),
    }
}

async fn call_off(State(shared): State<Shared>) -> StatusCode {
    work::call_off(&shared.desk);
    StatusCode::NO_CONTENT
}

#[derive(Deserialize)]
struct FileName {
    name: String,
}

async fn drop_file(
    State(shared): State<Shared>,
    Query(file): Query<FileName>,
    body: Bytes,
) -> Response {
    computed(move || {
        let kept = shared.desk.dropped().keep(&file.name, &body);
        kept.map(|()| json!(null))
    })
    .await
}

async fn dropped(State(shared): State<Shared>) -> Response {
    computed(move || Ok(drop_facts(&shared, &Corrections::default()))).await
}

fn drop_facts(shared: &Shared, corrections: &Corrections) -> Value {
    let bench = shared.desk.bench();
    let open = bench
        .as_ref()
        .map(|bench| bench.session.bench().name.as_str());
    shared.desk.dropped().facts(corrections, open)
}

async fn correct(State(shared): State<Shared>, Json(corrections): Json<Corrections>) -> Response {
    computed(move || Ok(drop_facts(&shared, &corrections))).await
}

#[derive(Deserialize)]
struct LeftOut {
    name: Option<String>,
}

/// Forgets one of the dropped files, or all of them.
async fn forget(State(shared): State<Shared>, Query(file): Query<LeftOut>) -> StatusCode {
    match file.name {
        Some(name) => shared.desk.dropped().leave_out(&name),
        None => shared.desk.dropped().clear(),
    }
    StatusCode::NO_CONTENT
}

#[derive(Deserialize)]
struct BenchText {
    text: String,
}

async fn check_text(State(shared): State<Shared>, Json(bench): Json<BenchText>) -> Response {
    computed(move || Ok(shared.desk.dropped().check(&bench.text))).await
}

#[derive(Deserialize)]
struct EffectText {
    name: String,
    text: String,
}

/// Reads the text of an effect as its file is read, while it is typed.
async fn check_effect(Json(effect): Json<EffectText>) -> Response {
    computed(move || {
        Ok(
            match workbench::check_own_effect(&effect.name, &effect.text) {
                Ok(parameters) => json!({"parameters": parameters}),
                Err(error) => json!({
                    "message": error.message,
                    "line": error.line,
                    "position": error.position,
                }),
            },
        )
    })
    .await
}

async fn design(State(shared): State<Shared>, Json(asked): Json<Asked>) -> Response {
    let Some(bench) = shared.desk.bench() else {
        return no_bench();
    };
    computed(move || design_facts::design(&bench, asked)).await
}

async fn controller(State(shared): State<Shared>) -> Response {
    computed(move || {
        let bench = shared.desk.bench();
        Ok(bench.map_or(Value::Null, |bench| facts::controller(&bench)))
    })
    .await
}

/// Parameters and matrices for another program.
async fn export(State(shared): State<Shared>, Path(language): Path<ExportLanguage>) -> Response {
    let Some(bench) = shared.desk.bench() else {
        return no_bench();
    };
    let made = tokio::task::spawn_blocking(move || {
        let designed = bench.session.design().map_err(said)?;
        Ok::<_, String>(designed.export(language))
    });
    match made.await {
        Ok(Ok(file)) => {
            // The name is made of letters, digits and underscores.
            let place = format!("attachment; filename=\"{}\"", file.name);
            let headers = [
                (CONTENT_TYPE, "text/plain; charset=utf-8".to_owned()),
                (CONTENT_DISPOSITION, place),
            ];
            (headers, file.text).into_response()
        }
        Ok(Err(message)) => refused(StatusCode::UNPROCESSABLE_ENTITY, message),
        Err(_) => bug(),
    }
}

async fn report(State(shared): State<Shared>) -> Response {
    let Some(bench) = shared.desk.bench() else {
        return no_bench();
    };
    let made = tokio::task::spawn_blocking(move || {
        crate::report::report(&ReportFindings {
            session: &bench.session,
            comparison: &bench.comparison,
            diagnosis: bench.diagnosis.as_ref().map(|found| &found.report),
            proof: bench.proof.as_ref().ok_or("no proof was made"),
        })
    });
    match made.await {
        Ok(Ok(text)) => {
            let headers = [
                (CONTENT_TYPE, "text/html; charset=utf-8"),
                (CONTENT_DISPOSITION, "attachment; filename=\"report.html\""),
            ];
            (headers, text).into_response()
        }
        Ok(Err(error)) => refused(StatusCode::UNPROCESSABLE_ENTITY, error.to_string()),
        Err(_) => bug(),
    }
}

/// Computes in a thread for long work.
async fn computed(work: impl FnOnce() -> Result<Value, String> + Send + 'static) -> Response {
    match tokio::task::spawn_blocking(work).await {
        Ok(Ok(value)) => Json(value).into_response(),
        Ok(Err(message)) => refused(StatusCode::UNPROCESSABLE_ENTITY, message),
        Err(_) => bug(),
    }
}

fn bug() -> Response {
    refused(
        StatusCode::INTERNAL_SERVER_ERROR,
        "internal error: this is a bug in flywheel, please report it",
    )
}
