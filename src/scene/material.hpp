#pragma once
// A cloth's material: one struct for the scene, the model and the backends.

namespace drench {

/// A fabric as the scene gives it and the stages use it. Number is double in the scene and the model, and a backend's
/// own type on its device. These defaults are those of a scene's cloth.
template <class Number>
struct BasicMaterial {
  Number thickness = Number(0.001);   // τ, m
  Number compression = Number(5000);  // Pa; presses the fabric to half of its thickness
  Number damping = Number(1.0);       // 1/s, of the nodes' velocity; dry
  Number strain_damping = Number(0);  // s: a spring's force grows by this time × its rate of stretching (Kelvin–Voigt)
  Number friction = Number(0.3);      // 1; dry fabric on solids 0.3–0.5
  Number strain_limit = Number(0);    // ε, 1: triangles keep their stretches within [1 − ε, 1 + ε]; 0: no limit
  Number adhesion = Number(0);        // w, N/m; work per area that separates the liquid from the cloth
  // of fabric that takes up liquid
  Number solid_fraction = Number(0.4);     // Φ, 1
  Number absorption = Number(0.01);        // k_a, m²/s
  Number max_saturation = Number(1.18);    // s_max, 1
  Number virtual_pressure = Number(16.8);  // k^p, m/s²
  Number emission_velocity = Number(0.5);  // u_e, m/s; excess is buffered for emission at the rate u_e / d
  Number emission_ramp = Number(0.02);     // s; over which a fresh particle's pressure and speed are ramped in
  Number diffusivity = Number(1.0e-4);     // D, m²/s; resolved, the geometric mean of warp and weft
  Number capillary_height = Number(1.0);   // ℓ, m
  Number retention_exponent = Number(1);   // β, 1: at rest sᵝ falls by 1 over the capillary height
  Number drainage_height = Number(0);      // ℓ_d, m: the same of fabric that drains; 0: as the capillary height
  Number drainage_exponent = Number(0);    // β_d, 1: the retention exponent of fabric that drains; 0: as β
  Number large_pores = Number(0);          // w, 1: share of the pores' volume that is in large ones, between yarns
  Number large_pore_height = Number(0);    // ℓ₂, m: their capillary height
  Number pore_narrowing = Number(0);       // c, 1: stretched by the area strain e its pores are finer by 1 + c e
  Number wet_adhesion = Number(0);    // w, N/m; parts wet fabric from wet fabric or a solid; 0.14 with water at most
  Number film = Number(0);            // δ, m: thickest film of liquid on each face; 0: none
  Number film_viscosity = Number(0);  // m²/s, of the film; 0: that of the liquid
  Number permeability = Number(0);    // k, m²: of the wet fabric, across it; 0: tight to pressure
  Number forchheimer = Number(0);     // β, 1/m: quadratic drag across it
  Number fibre_diameter = Number(0);  // d_f, m: sets β by Ergun's equation; 0: not known
  Number breakthrough_pressure = Number(0);  // p_b, Pa: below it the fabric repels liquid; 0: it wets by itself
  Number critical_saturation = Number(0.3);  // s_c, 1: below it drying slows down
  Number hygral_expansion = Number(0);       // 1: relative growth of its lengths at saturation 1
  Number compressibility = Number(0);        // c, 1: share of the thickness that pressure can take; 0: pores stay
  bool contact_wicking = false;              // liquid passes between layers that touch and both have this
  bool porous = false;                       // takes up liquid; else it is a dry wall

  /// Does liquid spread within the fabric?
  constexpr bool wicks() const { return porous && diffusivity > 0; }
  /// Does liquid pass through it?
  constexpr bool permeable() const { return porous && permeability > 0; }
  /// Does pressure close its pores?
  constexpr bool squeezes() const { return porous && compressibility > 0; }
  /// The saturation that is never exceeded, 1: what the pores and the film on both faces hold.
  constexpr Number ceiling() const {
    return has_film() ? 1 + 2 * film / ((1 - solid_fraction) * thickness) : max_saturation;
  }
  /// Does liquid beyond its pores run down on its faces?
  constexpr bool has_film() const { return wicks() && film > 0; }
  /// Does it hold liquid higher up while it drains than while it is wetted?
  constexpr bool has_hysteresis() const { return wicks() && drainage_height > capillary_height; }
  /// ℓ_d/ℓ.
  constexpr Number drainage_ratio() const { return has_hysteresis() ? drainage_height / capillary_height : Number(1); }
  /// Does it have pores of two sizes?
  constexpr bool has_large_pores() const { return wicks() && large_pores > 0; }
  /// Does liquid flow by the suction of its pores, or by the saturation alone?
  constexpr bool flows_by_suction() const { return has_hysteresis() || has_large_pores() || narrows(); }
  /// Does stretching change its pores?
  constexpr bool narrows() const { return wicks() && pore_narrowing != 0; }
  /// Does it pass into layers that touch?
  constexpr bool wicks_through_contact() const { return wicks() && contact_wicking; }

  bool operator==(const BasicMaterial&) const = default;
};

/// The same as the stages use it: with what follows from other keys when a scene is set up (setup/cloth_material.hpp).
template <class Number>
struct ResolvedMaterial : BasicMaterial<Number> {
  Number compression_per_mass{};  // compression over the mass per unit area, Pa m²/kg
  Number rigid_share{};           // 1: share of the thickness that no pressure takes
  Number release{};               // m/s: largest speed at which a node that begins a step inside a solid comes out
  Number friction_wet{};          // 1, at saturation 1
  Number damping_wet{};           // 1/s, at saturation 1
  Number emission_cosine{};       // cos θ^e; −2, below all cosines, where there is no direction and so no cone
  Number diffusion_exponent{};    // n, 1: liquid spreads at the rate D sⁿ
  Number conductance{};           // k/(ν τ), s/m: flux through the saturated sheet over the difference of p/ρ0
  Number inertial_loss{};         // β τ, 1: difference of p/ρ0 that the square of the flux costs, over that square
  Number entry_potential{};       // p_b/ρ0, m²/s²
  Number film_depth{};            // (1 − Φ) τ, m: thickness of the film on both faces over s − 1; 0: no film
  Number film_flow{};           // ρ0 |g|/(12 ν), kg/(m⁴ s): flow of a film over its thickness³ and drop in height
  Number film_growth{};         // ρ0/(12 ν σ), s³/m⁵: rate at which a film drips over its thickness³ and pull²
  bool dynamics = true;         // false: it does not move
  bool self_collision = false;  // with itself and with other cloths that have this
};

/// Calls visit(of a, of b) for every member: the one list of them. tests/app/material_test.cpp sees that none is
/// missing.
template <class A, class B, class Visit>
constexpr void visit_members(ResolvedMaterial<A>& a, const ResolvedMaterial<B>& b, Visit visit) {
  visit(a.thickness, b.thickness);
  visit(a.compression, b.compression);
  visit(a.damping, b.damping);
  visit(a.strain_damping, b.strain_damping);
  visit(a.friction, b.friction);
  visit(a.strain_limit, b.strain_limit);
  visit(a.adhesion, b.adhesion);
  visit(a.solid_fraction, b.solid_fraction);
  visit(a.absorption, b.absorption);
  visit(a.max_saturation, b.max_saturation);
  visit(a.virtual_pressure, b.virtual_pressure);
  visit(a.emission_velocity, b.emission_velocity);
  visit(a.emission_ramp, b.emission_ramp);
  visit(a.diffusivity, b.diffusivity);
  visit(a.capillary_height, b.capillary_height);
  visit(a.retention_exponent, b.retention_exponent);
  visit(a.drainage_height, b.drainage_height);
  visit(a.drainage_exponent, b.drainage_exponent);
  visit(a.large_pores, b.large_pores);
  visit(a.large_pore_height, b.large_pore_height);
  visit(a.pore_narrowing, b.pore_narrowing);
  visit(a.wet_adhesion, b.wet_adhesion);
  visit(a.film, b.film);
  visit(a.film_viscosity, b.film_viscosity);
  visit(a.permeability, b.permeability);
  visit(a.forchheimer, b.forchheimer);
  visit(a.fibre_diameter, b.fibre_diameter);
  visit(a.breakthrough_pressure, b.breakthrough_pressure);
  visit(a.critical_saturation, b.critical_saturation);
  visit(a.hygral_expansion, b.hygral_expansion);
  visit(a.compressibility, b.compressibility);
  visit(a.contact_wicking, b.contact_wicking);
  visit(a.porous, b.porous);
  visit(a.compression_per_mass, b.compression_per_mass);
  visit(a.rigid_share, b.rigid_share);
  visit(a.release, b.release);
  visit(a.friction_wet, b.friction_wet);
  visit(a.damping_wet, b.damping_wet);
  visit(a.emission_cosine, b.emission_cosine);
  visit(a.diffusion_exponent, b.diffusion_exponent);
  visit(a.conductance, b.conductance);
  visit(a.inertial_loss, b.inertial_loss);
  visit(a.entry_potential, b.entry_potential);
  visit(a.film_depth, b.film_depth);
  visit(a.film_flow, b.film_flow);
  visit(a.film_growth, b.film_growth);
  visit(a.dynamics, b.dynamics);
  visit(a.self_collision, b.self_collision);
}

/// The same material in another type of numbers, each rounded once.
template <class To, class From>
constexpr ResolvedMaterial<To> material_in(const ResolvedMaterial<From>& material) {
  ResolvedMaterial<To> result;
  visit_members(result, material, []<class T>(T& to, const auto& from) { to = static_cast<T>(from); });
  return result;
}

}  // namespace drench
