#pragma once
// Stage jets: lets layers of full particles go from the nozzles.
//
// Law.  A jet of radius R and speed |v| carries ρ0 π R² |v| kg/s. Layer k leaves at t_k = start + k · layer_interval,
// and the interval
//       n d³/(π R² |v|) (s, n particles a layer) makes that mean flow exact. In a step that ends at t' = time + Δt,
//       every layer k with t_k ≤ t' and t_k < end that has not left yet is created at centre + offset + v (t' − t_k),
//       velocity v, mass m0, age 0, Origin::jet, ids in order. A layer waits (and all after it) while its start is in
//       the future only; `supplied` grows by the mass created.
// Reads:  Model::jets, time.   Writes: fluid_* (appended), next_id, jet_layers, supplied.
