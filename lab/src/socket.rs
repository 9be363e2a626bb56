//! The socket of a page: it requests curves, also with other parameter values, and receives the progress of tasks.

use std::borrow::Borrow;
use std::collections::BTreeMap;
use std::sync::Arc;
use std::time::Duration;

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

/// Interval of the checks whether another program has changed a file of the bench. A judgement: a person who has saved a
/// file and turns to the page finds it noticed.
const LOOK_OUTSIDE_EVERY: Duration = Duration::from_secs(2);

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
    /// Without the measurements, which the page has.
    #[serde(default)]
    model_only: bool,
}

/// The curves of the experiments that were asked for, with the model and the changes to which they belong.
struct Simulated {
    bench: Arc<OpenBench>,
    changes: Vec<(String, f64)>,
    /// By the place of the experiment in the list.
    curves: BTreeMap<usize, Arc<ExperimentCurves>>,
}

/// Opens the socket.
pub async fn upgrade(State(shared): State<Shared>, upgrade: WebSocketUpgrade) -> Response {
    upgrade
        .max_message_size(LARGEST_MESSAGE)
        .on_upgrade(move |socket| talk(shared, socket))
}

async fn talk(shared: Shared, mut socket: WebSocket) {
    let mut events = shared.desk.listen();
    let mut last: Option<Simulated> = None;
    let mut look = tokio::time::interval(LOOK_OUTSIDE_EVERY);
    let mut told: Vec<String> = Vec::new();
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
            _ = look.tick() => {
                let desk = shared.desk.clone();
                let changed = tokio::task::spawn_blocking(move || desk.changed_outside()).await;
                match changed {
                    Ok(changed) if changed != told => {
                        told = changed;
                        Message::text(json!({"event": "outside", "files": told}).to_string())
                    }
                    _ => continue,
                }
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
    last: &mut Option<Simulated>,
) -> Result<Vec<u8>, String> {
    let question: Question = serde_json::from_str(text).map_err(|error| error.to_string())?;
    let bench = shared.desk.bench().ok_or("no bench is open")?;
    let index = question.experiment;
    // A zoom requests the same curves again.
    let same = last
        .take()
        .filter(|last| Arc::ptr_eq(&last.bench, &bench))
        .filter(|last| question.changes.is_empty() || last.changes == question.changes);
    let mut simulations = same.unwrap_or_else(|| Simulated {
        bench: bench.clone(),
        changes: question.changes.clone(),
        curves: BTreeMap::new(),
    });
    let known = simulations.curves.get(&index).cloned();
    let computing = tokio::task::spawn_blocking(move || {
        if question.changes.is_empty() {
            // The model as it is was simulated when it was compared.
            let found = bench.comparison.curves.as_slice();
            let curves = found.get(index).ok_or(NO_EXPERIMENT)?;
            return Ok((None, answer(curves, found, &question)?));
        }
        let curves = match known {
            Some(known) => known,
            None => Arc::new(simulated(&bench, &question)?),
        };
        let answer = answer(&curves, std::slice::from_ref(&curves), &question)?;
        Ok::<_, String>((Some(curves), answer))
    });
    let (curves, answer) = computing
        .await
        .map_err(|_| "internal error: this is a bug in flywheel, please report it")??;
    if let Some(curves) = curves {
        simulations.curves.insert(index, curves);
    }
    *last = Some(simulations);
    Ok(answer)
}

/// The message to a page whose list of experiments is an old one.
const NO_EXPERIMENT: &str = "there is no such experiment";

/// The experiment that is asked for, simulated with the changed parameters.
fn simulated(bench: &OpenBench, question: &Question) -> Result<ExperimentCurves, String> {
    let changes = question.changes.iter();
    let changes: Vec<(&str, f64)> = changes
        .map(|(name, value)| (name.as_str(), *value))
        .collect();
    let curves = bench
        .predictor
        .curves_of(question.experiment, &changes)
        .map_err(|error| error.to_string())?;
    curves.ok_or_else(|| NO_EXPERIMENT.to_owned())
}

/// The format of an answer: the length of the header in bytes (u32, little-endian), the header as JSON, zeros up to
/// a multiple of eight, then numbers as f64, little-endian. The header describes the numbers, and has the errors of
/// the experiments `rated`. Where the page has the measurements they are left out.
fn answer<C: Borrow<ExperimentCurves>>(
    curves: &ExperimentCurves,
    rated: &[C],
    question: &Question,
) -> Result<Vec<u8>, String> {
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
            let measured = match question.model_only {
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
    let errors = rated.iter().flat_map(|curves| {
        let curves: &ExperimentCurves = curves.borrow();
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
