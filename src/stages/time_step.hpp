#pragma once
// Stage time_step: chooses Δt before anything else in the step, and resets what the step accumulates.
//
// Law:    docs/theory/liquid.md, Time step: modes `fixed` and `cfl` (Eq. 26), capillary waves (27); mode `error` (27a),
//         in which the pipeline shortens what this stage allows.
// Reads:  the scene's `time`; in mode cfl fluid_velocity, node_velocity (m/s), fluid_position (m, with a field),
//         body_*.
// Writes: StepReport::dt_wanted (s); node_pin_force := 0 (N). The pipeline may shorten Δt to end at an output time.
// Errors: none here. The pipeline ends a run whose Δt is not positive and finite.
