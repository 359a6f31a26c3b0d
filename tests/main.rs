//! Every test of the project but the one that needs a machine of its own (`control_loop`): one program, so that it is linked
//! once and its tests share both cores to the end. `cargo test --test all import::` runs those of one file.

// that of the binary
#[global_allocator]
static ALLOCATOR: mimalloc::MiMalloc = mimalloc::MiMalloc;

mod answers;
mod arm;
mod automation;
mod bad_input;
mod batch;
mod blind_generator;
mod bodies;
mod catalogue;
mod chapter3;
mod command_output;
mod compensate;
mod control;
mod control_parameters;
mod derivatives;
mod deviations;
mod diagnose_concealed;
mod diagnose_local;
mod diagnose_output;
mod diagnose_parts;
mod diagnose_seats;
mod diagnose_standing;
mod diagnose_swinging;
mod effects;
mod formats_doc;
mod gallery;
mod hidden_causes;
mod hidden_rows;
mod history;
mod house;
mod identify_json;
mod import;
mod init;
mod instrument;
mod inverse;
mod irb120;
mod json_schemas;
mod linear_axes;
mod linuxcnc;
mod linuxcnc_kinematics;
mod loads;
mod machines;
mod meshes;
mod mistakes;
mod nc_programs;
mod noise_fits;
mod not_recorded;
mod not_returning;
mod one_run;
mod output_sets;
mod peer_scene;
mod plan_budget;
mod plan_collision;
mod plan_json;
mod plan_machines;
mod plan_reasons;
mod plan_recovery;
mod planar_circles;
mod practice_effects;
mod random_sessions;
mod readers;
mod readings;
mod readme;
mod reconcile;
mod reconcile_recordings;
mod recovery;
mod reference;
mod replay;
mod saved_fit;
mod senses;
mod sensors;
mod setup_sheet;
mod survey;
mod table_1_1;
mod thesis_errata;
mod thesis_methods;
mod thesis_mismatch;
mod thesis_sessions;
mod travel;
mod unchanging;
mod urdf;
mod urdf_collision;
mod volume;
mod weights;
mod written_files;

// what several of them use
mod captured;
mod erring;
mod finite_differences;
mod following;
mod nc_reader;
mod noisy;
mod plain_machine;
mod plain_program;
mod planned;
mod published;
mod recorded;
mod schema;
mod second_order;
mod shared_data;
mod shipped;
mod skipped;
mod trunnion;

// sessions of the examples, whose physics uses nothing of the library
#[path = "../examples"]
#[allow(dead_code, reason = "the examples write and print more than the tests read")]
mod examples {
    pub mod blind_trial {
        pub mod case;
        pub mod designs;
        pub mod draw;
        pub mod effects;
        pub mod faults;
        pub mod kinematics;
        pub mod machines;
        pub mod mounting;
        pub mod noise;
        pub mod nuisance;
        pub mod plan;
        pub mod recordings;
        pub mod visibility;
    }
    pub mod thesis_mismatch {
        pub mod causes;
        pub mod designs;
        pub mod outcome;
    }
    pub mod thesis_sessions {
        pub mod besides;
        pub mod design;
        pub mod files;
        pub mod kinematics;
        pub mod noise;
        pub mod session;
    }
}
