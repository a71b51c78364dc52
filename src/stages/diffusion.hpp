#pragma once
// Stage diffusion: liquid spreads within the fabric (in the place of paper Eq. 11), and passes between layers that
// touch where `porous.contact_wicking` asks for it. Masses in quanta. At the rate D sⁿ, of its own along warp and weft.
//
// Law:    docs/theory/porous.md. 1 conductance, 2 flux, 3 sub-steps and limiters (sections 6, 10), 4 contacts, 5 their
//         flux, 6 their transfer (section 7), 7 reservoirs between sub-steps (section 8), 8 momentum (section 9), 9
//         films (section 16), squeezed fabric (section 17, Eq. 43a), hysteresis (section 18),
//         pores of two sizes (section 19), of stretched fabric (section 20).
// Reads:  node_position (m), node_velocity (m/s), node_liquid (quanta), Model::fabric, list sample→sample.
// Writes: node_liquid (quanta), node_velocity (m/s), supplied (quanta); StepReport::diffusion_substeps; with hysteresis
//         node_scanning, node_extreme (1).
// Solute: goes along with its liquid (docs/theory/solute.md): node_solute, solute_supplied (quanta).
// Errors: RunFailure (sub_steps) for more than 10^6 sub-steps (src/pipeline/substeps.hpp).
