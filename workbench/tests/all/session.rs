//! Opening, fitting, adding and removing.

use std::fs;

use workbench::{Error, FilesInMemory, Output, Session};

use crate::bench::{files, session, silent};

#[test]
fn memory_and_folder_give_the_same() {
    let folder = tempfile::tempdir().expect("a folder");
    for (name, text) in files() {
        fs::write(folder.path().join(name), text).expect("written");
    }
    let mut on_disk = Session::open(folder.path()).expect("a bench");
    let mut in_memory = session();
    let of_disk = on_disk.identify(&silent()).expect("a fit");
    let of_memory = in_memory.identify(&silent()).expect("a fit");
    assert_eq!(of_disk.parameters, of_memory.parameters);
    assert_eq!(of_disk.rmse, of_memory.rmse);
    assert_eq!(of_disk.places, of_memory.places);
    assert_eq!(on_disk.model(), in_memory.model());

    on_disk.save_model().expect("a folder that can be written");
    let again = Session::open(folder.path()).expect("the bench again");
    assert_eq!(again.model(), on_disk.model(), "the file says the same");
    assert!(matches!(in_memory.save_model(), Err(Error::NoPlace)));
    // A model among the files in memory is read too.
    let model = on_disk.model().expect("a model").to_toml();
    let mut all: FilesInMemory = files().into_iter().collect();
    all.insert("model.toml", model);
    let with_model = Session::from_files(&all).expect("a bench");
    assert_eq!(with_model.model(), on_disk.model());
}

#[test]
fn what_is_added_and_removed_again_leaves_the_parameters_as_they_were() {
    let mut session = session();
    let before = session.identify(&silent()).expect("a fit");
    let added = session
        .add_effect("body-coulomb-friction", &silent())
        .expect("a fit with dry friction");
    assert_eq!(added.rmse_before, before.rmse);
    let angle =
        |numbers: &workbench::PerSeries| numbers.get("swing", Output::Angle).expect("an angle");
    // The base model has a visible error, which falls to the noise of the sensor with the effect.
    let noise = angle(&added.after.sensor_noise);
    let (before_rmse, after_rmse) = (angle(&added.rmse_before), angle(&added.after.rmse));
    assert!(before_rmse > 3.0 * noise, "{before_rmse} {noise}");
    assert!(after_rmse < 1.1 * noise, "{after_rmse} {noise}");
    let torque = added.after.parameter("body_coulomb_torque");
    let torque = torque.expect("the effect's parameter");
    let std = torque.std.expect("a standard error");
    assert!(
        (torque.value - demo::COULOMB_TORQUE_NM).abs() < 4.0 * std,
        "{torque:?}"
    );

    let removed = session
        .remove_effect("body-coulomb-friction", &silent())
        .expect("a fit without");
    assert_eq!(removed.after.parameters, before.parameters);
    assert_eq!(removed.after.correlation, before.correlation);
    assert_eq!(removed.after.effects, before.effects);
}

/// A body that is known per unit of inertia and a wheel in kg m² have no motion together: no controller is made of them.
#[test]
fn inertias_on_two_scales_are_refused() {
    let model = |wheel: &str, unit: &str| {
        format!(
            "[parameters.total_inertia]\nvalue = 1.0\nunit = \"kg m2 per kg m2\"\n\
             [parameters.wheel_inertia]\nvalue = {wheel}\n{unit}\
             [parameters.gravity_torque]\nvalue = 105.9\nunit = \"N m per kg m2\"\n\
             [parameters.torque_constant]\nvalue = 0.033\n\
             [parameters.body_viscous_friction]\nvalue = 0.11\n\
             [parameters.wheel_viscous_friction]\nvalue = 1.6e-5\n\
             [effects]\npresent = [\"body-viscous-friction\", \"wheel-viscous-friction\"]\n\
             [design]\nsample_time = 1e-3\nstate_weights = [25.0, 0.5, 5e-4]\n\
             current_weight = 1.0\ncurrent_limit = 2.0\n"
        )
    };
    let designed = |wheel: &str, unit: &str| {
        let path = std::path::Path::new("model.toml");
        let file = bench_files::ModelFile::parse(&model(wheel, unit), path).expect("a model");
        workbench::ControlDesign::of(file)
    };
    let open = |wheel: &str, unit: &str| match designed(wheel, unit) {
        Err(Error::OpenScale { unknown, .. }) => unknown,
        other => panic!("{other:?}"),
    };
    assert_eq!(open("1.15e-4", ""), "total_inertia");
    let unit = "unit = \"kg m2 per kg m2\"\n";
    assert_eq!(open("1.0", unit), "total_inertia and wheel_inertia");
    // A wheel that was fitted in units of the body's inertia is on the same scale.
    assert!(!matches!(
        designed("0.051", unit),
        Err(Error::OpenScale { .. })
    ));
}

/// A model that a diagnosis did not explain says so where a controller is made of it, until other parameters replace it.
#[test]
fn a_model_that_explains_nothing_cautions_the_design() {
    let mut session = session();
    session.identify(&silent()).expect("a fit");
    let mut file = session.model().expect("a model").clone();
    file.unexplained = Some("Unexplained: an error remains.".to_owned());
    let again = bench_files::ModelFile::parse(&file.to_toml(), std::path::Path::new("model.toml"));
    let mut again = again.expect("a model");
    again.design = Some(session.usual_design());
    let report = |file: bench_files::ModelFile| {
        let designed = workbench::ControlDesign::of(file).expect("a design");
        designed.report().expect("a report").cautions
    };
    let cautions = report(again.clone());
    assert!(
        cautions.len() == 1 && cautions[0].contains("an error remains"),
        "{cautions:?}"
    );
    again.replace_model_parameters(again.parameters.clone(), None);
    assert_eq!(report(again), Vec::<String>::new());
}

#[test]
fn what_cannot_be_is_said_with_its_place() {
    let mut session = session();
    assert!(matches!(
        session.compare(&silent()),
        Err(Error::NoModel { .. })
    ));
    assert!(matches!(
        session.add_effect("nonsense", &silent()),
        Err(Error::UnknownEffect { .. })
    ));
    assert!(matches!(
        session.add_effect("body-viscous-friction", &silent()),
        Err(Error::EffectPresent { .. })
    ));
    session.identify(&silent()).expect("a fit");
    assert!(matches!(
        session.remove_effect("wheel-cogging", &silent()),
        Err(Error::EffectAbsent { .. })
    ));

    let mut broken: FilesInMemory = files().into_iter().collect();
    broken.insert("spin-up-0.4A.csv", "time_s,wheel_speed_rad_s\n0,1\n0.1,x\n");
    let Err(Error::File(error)) = Session::from_files(&broken) else {
        panic!("a letter is no number");
    };
    assert_eq!(error.place().line, Some(3));
    assert_eq!(error.place().column.as_deref(), Some("wheel_speed_rad_s"));
}

#[test]
fn a_check_names_the_experiments_and_finds_no_contradiction() {
    let check = session().check(&silent()).expect("a check");
    let names: Vec<&str> = check
        .experiments
        .iter()
        .map(|one| one.name.as_str())
        .collect();
    assert_eq!(names, ["spin-up", "swing"]);
    assert_eq!(check.contradictions, Vec::<String>::new());
}
