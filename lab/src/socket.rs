//! The socket of a page: it requests curves, also with other parameter values, and receives the progress of tasks.

use std::sync::Arc;

use axum::extract::State;
use axum::extract::ws::{Message, WebSocket, WebSocketUpgrade};
use axum::response::Response;
use serde::Deserialize;
use serde_json::{Value, json};
use tokio::sync::broadcast::error::RecvError;
use workbench::ExperimentCurves;

use crate::desk::OpenBench;
use crate::facts::error_row;
use crate::picture::{Curve, View, thinned};
use crate::shared::Shared;

/// Largest message from a page, bytes.
const LARGEST_MESSAGE: usize = 64 * 1024;
/// Largest width in pixels for which curves are computed.
const MOST_PIXELS: usize = 8000;

/// A request from a page.
#[derive(Clone, Debug, Deserialize)]
struct Question {
    /// Returned with the answer.
    id: u64,
    /// Index of the experiment in the list.
    experiment: usize,
    /// Left edge, s; `None`: the beginning.
    from_s: Option<f64>,
    /// Right edge, s; `None`: the end.
    to_s: Option<f64>,
    /// Width of the screen in pixels.
    pixels: usize,
    /// Parameters with other values than in the model.
    changes: Vec<(String, f64)>,
    /// Only what the model says of this experiment: for a curve that follows a hand.
    #[serde(default)]
    alone: bool,
}

/// Curves of all experiments, with the model and the changes to which they belong.
struct Simulated {
    bench: Arc<OpenBench>,
    changes: Vec<(String, f64)>,
    curves: Vec<ExperimentCurves>,
}

/// Opens the socket.
pub async fn upgrade(State(shared): State<Shared>, upgrade: WebSocketUpgrade) -> Response {
    upgrade
        .max_message_size(LARGEST_MESSAGE)
        .on_upgrade(move |socket| talk(shared, socket))
}

async fn talk(shared: Shared, mut socket: WebSocket) {
    let mut events = shared.desk.listen();
    let mut last: Option<Arc<Simulated>> = None;
    loop {
        let answer = tokio::select! {
            event = events.recv() => match event {
                Ok(event) => Message::text(event),
                // The page then requests the state again.
                Err(RecvError::Lagged(_)) => Message::text(json!({"event": "lagged"}).to_string()),
                Err(RecvError::Closed) => return,
            },
            asked = socket.recv() => match asked {
                Some(Ok(Message::Text(text))) => match answer_to(&shared, &text, &mut last).await {
                    Ok(bytes) => Message::binary(bytes),
                    Err(message) => Message::text(
                        json!({"event": "refused", "message": message}).to_string(),
                    ),
                },
                Some(Ok(Message::Close(_)) | Err(_)) | None => return,
                Some(Ok(_)) => continue,
            },
        };
        if socket.send(answer).await.is_err() {
            return;
        }
    }
}

async fn answer_to(
    shared: &Shared,
    text: &str,
    last: &mut Option<Arc<Simulated>>,
) -> Result<Vec<u8>, String> {
    let question: Question = serde_json::from_str(text).map_err(|error| error.to_string())?;
    let bench = shared.desk.bench().ok_or("no bench is open")?;
    // A zoom requests the same curves again.
    let known = last
        .clone()
        .filter(|known| Arc::ptr_eq(&known.bench, &bench) && known.changes == question.changes);
    let computing = tokio::task::spawn_blocking(move || {
        let simulated = match known {
            Some(known) => known,
            None if question.alone => {
                let curves = simulate_one(&bench, &question)?;
                return Ok((None, answer(&curves, &[], &question)?));
            }
            None => Arc::new(simulate(bench, &question)?),
        };
        let curves = simulated.curves.get(question.experiment);
        let curves = curves.ok_or(NO_EXPERIMENT)?;
        let answer = answer(curves, &simulated.curves, &question)?;
        Ok::<_, String>((Some(simulated), answer))
    });
    let (simulated, answer) = computing
        .await
        .map_err(|_| "internal error: this is a bug in flywheel, please report it")??;
    *last = simulated.or(last.take());
    Ok(answer)
}

/// The message to a page whose list of experiments is an old one.
const NO_EXPERIMENT: &str = "there is no such experiment";

fn changes_of(question: &Question) -> Vec<(&str, f64)> {
    let changes = question.changes.iter();
    changes
        .map(|(name, value)| (name.as_str(), *value))
        .collect()
}

fn simulate_one(bench: &OpenBench, question: &Question) -> Result<ExperimentCurves, String> {
    let curves = bench
        .predictor
        .curves_of(question.experiment, &changes_of(question))
        .map_err(|error| error.to_string())?;
    curves.ok_or_else(|| NO_EXPERIMENT.to_owned())
}

fn simulate(bench: Arc<OpenBench>, question: &Question) -> Result<Simulated, String> {
    let curves = bench
        .predictor
        .curves(&changes_of(question))
        .map_err(|error| error.to_string())?;
    Ok(Simulated {
        bench,
        changes: question.changes.clone(),
        curves,
    })
}

/// The format of an answer: the length of the header in bytes (u32, little-endian), the header as JSON, zeros up to
/// a multiple of eight, then numbers as f64, little-endian. The header describes the numbers, and has the errors of
/// `all` experiments, or of this one where there are no others. For a curve that follows a hand the measurements are left
/// out: the page has them.
fn answer(
    curves: &ExperimentCurves,
    all: &[ExperimentCurves],
    question: &Question,
) -> Result<Vec<u8>, String> {
    let all = match all {
        [] => std::slice::from_ref(curves),
        all => all,
    };
    let time_s = &curves.time_s;
    let (Some(&first), Some(&last)) = (time_s.first(), time_s.last()) else {
        return Err("the experiment has no samples".to_owned());
    };
    let view = View {
        from_s: question.from_s.filter(|t| t.is_finite()).unwrap_or(first),
        to_s: question.to_s.filter(|t| t.is_finite()).unwrap_or(last),
        pixels: question.pixels.clamp(50, MOST_PIXELS),
    };
    if view.to_s <= view.from_s {
        return Err("the view ends before it begins".to_owned());
    }
    let mut numbers: Vec<f64> = Vec::new();
    let mut put = |curve: Curve| {
        let at = numbers.len();
        let count = curve.time_s.len();
        numbers.extend(curve.time_s);
        numbers.extend(curve.value);
        json!([at, count])
    };
    let channels: Vec<Value> = curves
        .channels
        .iter()
        .map(|channel| {
            // Around a push that nobody recorded, the model makes no prediction.
            let model = channel.simulated.iter().zip(&curves.counts);
            let model: Vec<f64> = model
                .map(|(value, counts)| if *counts { *value } else { f64::NAN })
                .collect();
            let pairs = channel.measured.iter().zip(&model);
            let residual: Vec<f64> = pairs.map(|(measured, model)| measured - model).collect();
            let measured = match question.alone {
                true => Curve::default(),
                false => thinned(time_s, &channel.measured, &view),
            };
            json!({
                "channel": channel.channel.name(),
                "measured": put(measured),
                "simulated": put(thinned(time_s, &model, &view)),
                "residual": put(thinned(time_s, &residual, &view)),
            })
        })
        .collect();
    let errors = all.iter().flat_map(|curves| {
        let name = &curves.experiment;
        let channels = curves.channels.iter();
        channels.map(move |channel| error_row(name, channel))
    });
    let errors: Vec<Value> = errors.collect();
    let header = json!({
        "id": question.id,
        "experiment": question.experiment,
        "span": [first, last],
        "view": [view.from_s, view.to_s],
        "channels": channels,
        "errors": errors,
    })
    .to_string();
    let mut bytes = Vec::with_capacity(header.len() + 12 + 8 * numbers.len());
    let length = u32::try_from(header.len()).map_err(|error| error.to_string())?;
    bytes.extend(length.to_le_bytes());
    bytes.extend(header.as_bytes());
    bytes.resize(bytes.len().next_multiple_of(8), 0);
    bytes.extend(numbers.iter().flat_map(|number| number.to_le_bytes()));
    Ok(bytes)
}
