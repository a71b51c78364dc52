#pragma once
// Stage micropolar: every liquid particle has a spin of its own, which drives the flow and is driven by it.
//
// After Bender, Koschier, Kugelstadt & Weiler 2017 and 2019 ("Turbulent micropolar SPH fluids with foam"), with sums that
// are each other's adjoints, and with a share a of the reaction that they leave out. ω: spin, 1/s; ν_t = `transfer`, m²/s;
// Θ = `inertia` d², m², the moment of inertia per mass; ζ = `viscosity`, m²/s, of the spin; a = `reaction`, 1.
// V_i = m_i/ρ0, x_ij = x_i − x_j, liquid neighbours j.
//
// Continuum.   Dv/Dt = ν_t ∇×ω − a (ν_t/2) ∇×∇×v,   Dω/Dt = (ν_t/Θ) (∇×v − 2 ω) + ζ Δω.
//       a = 1 is the micropolar fluid of Eringen (ν_t is twice his rotational viscosity): the antisymmetric stress resists
//       the slip ∇×v − 2ω and nothing else. a = 0 is theirs: spins are wound up for nothing.
//
// Laws. Slip of a particle's surroundings against its own rotation, 1/s:
//         c_i = Σ_j V_j v_ij × ∇W_ij,   s_i = Σ_j V_j (v_ij − ω_i × x_ij) × ∇W_ij,   s′_i = s_i − (1 − a) c_i
//       (c_i → ∇×v, s_i → ∇×v − 2ω; a rigid rotation has s_i = 0 at the surface too.)
//         dv_i/dt = (ν_t/2) Σ_j V_j (s′_i + s′_j) × ∇W_ij                                      m/s²
//         dω_i/dt = (ν_t/2Θ) Σ_j V_j (s_i × x_ij) × ∇W_ij + (χ ζ/5h²) Σ_j V_j |∇W_ij| r_ij (ω_j − ω_i)      1/s²
//       with χ of forces.hpp; then the last sum is ζ Δω in the continuum. Solids and cloth take no part: there the liquid's
//       spin ends as at a free surface.
//
// What is kept. Forces are antisymmetric: momentum always. The first sum of dω/dt is the torque per mass that the forces
//       of s take from the orbits, so that with a = 1 angular momentum Σ m (x × v + Θ ω) is kept; with a < 1 what spins
//       give to the flow leaves them, but of what they take (1 − a) (ν_t/2) Σ_i m_i Σ_j V_j (c_i × x_ij) × ∇W_ij, N m, comes
//       from nowhere. With L(v, ω) for the rates
//         Σ m (v·L_v + Θ ω·L_ω) = −(ν_t/2) Σ m [ |s|² − (1 − a) |c|² ] − the loss by ζ:
//       a = 1 never adds energy; a < 1 feeds the flow as a viscosity of −(1 − a) ν_t/2 would, at wavelengths above 2π√Θ; at
//       shorter ones the spins' inertia holds it back. A curl mode of wavenumber k grows, with a = 0 and ζ = 0, at
//         λ = (ν_t/Θ) (√(1 + k² Θ) − 1) < ν_t k²/2, ν_t k/√Θ   1/s,
//       and what the rest of the solver loses there is to hold it.
//
// Time. Positions stay. L is symmetric in the masses' and inertias' inner product, and its eigenvalues are not below −C,
//         C = (ν_t/2) (4 max_i g_i² + max_i k_i²/Θ) + 2 (χ ζ/5h²) max_i k_i,  g_i = Σ_j V_j |∇W_ij|, k_i = Σ_j V_j |∇W_ij| r_ij.
//       Stages of RKL1 as in forces.hpp, s the smallest number with s (s + 1) ≥ Δt C: no limit on Δt. Water has s = 1.
//
// Spins go with their particles. New particles (jets, emission) have none; liquid that cloth gives to a particle takes on its
// spin, and what it absorbs takes its own along.
// Reads:  positions, masses, lists, fluid_velocity, fluid_spin.   Writes: fluid_velocity, fluid_spin.
