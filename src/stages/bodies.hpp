#pragma once
// Stage bodies: the solids' poses and their samples. The laws of rigid bodies that other stages use stand here too.
//
// Pose.  Centre c (m), orientation q (unit quaternion, from t = 0 to now), velocity v (m/s) and angular velocity ω
//        (rad/s, world's axes). A material point that is at X at t = 0 is at x = c + q(X − C), C = Body::center, and moves
//        with v_s(x) = v + ω × (x − c). A rigid motion keeps the distances between a body's samples and so their
//        Akinci volumes V_b: those are computed once, at set-up, whether the body moves or not.
// Law 1, prescribed motion (`velocity`, `spin`): c = C + t v, q = Rot(spin_axis, spin_rate · t) at t = time + Δt, always
//        from t = 0, so that errors do not add up; v and ω are constant. Bodies at rest keep everything.
//        Of a plane, a floor that rises or tilts or a belt, the samples are a lattice without end: they go back by whole
//        steps of it, L_1 and L_2 in the plane, to where the domain's middle M is, x_b = c + q(X_b − Σ_k n_k L_k − C),
//        n_k = floor(((M − C) − q⁻¹(M − c))·L_k/L_k² + 0.382), and there need be no more of them than the domain can meet
//        (slide_offset: so that no simple fraction of a step is a borderline).
// Law 2, dynamic bodies (mass M, kg; inertia I about c, kg m²): c' = c + Δt v, q' = exp(Δt ω) q; angular momentum is kept,
//        ω' = I(q')⁻¹ I(q) ω, which is the gyroscopic term −ω × Iω to first order (no torque acts in this stage).
//        Contact with the bodies that are not dynamic (container, floor): up to three sweeps over them, in their order, at
//        the sphere's centre or the box's corners, in their order. A point that has entered by φ < 0 moves the body by
//        −φ n, and an inelastic impulse J = −u/(1/M + (r × n)·I⁻¹(r × n)) along n takes its normal velocity u < 0 relative
//        to the surface away (r from c to the point): v += J n/M, ω += I⁻¹(r × J n).
//        Simplifications: no friction and no bounce; a box's edges and faces do not feel what its corners miss; dynamic
//        bodies do not feel each other nor the cloth, which they push as a prescribed motion would.
//
// Used by other stages:
// Law 3, where solids stop cloth and liquid (stages cloth, pressure and advection, whose positions are those of the
//        step's end): at the pose of the step's end, c + Δt v, exp(Δt ω) q. A node or particle loses only what goes into the
//        surface, n min(0, (v − v_s)·n); friction is relative to v_s.
// Law 4, stage forces: dynamic bodies take part in its time stages as the cloth's nodes do, dv/dt = g + F/M,
//        dω/dt = I⁻¹ T, with the viscous reaction F_b = −Σ_i m_i a_ib (forces.hpp) on the samples, F = Σ_b F_b,
//        T = Σ_b (x_b − c) × F_b. The number of stages counts 2 max(Σ_b K_b/M, Σ_b K_b r_b²/I_min) for a body, K_b as
//        forces.hpp has it: Σ_b K_b |v + ω × r_b|² ≤ 2 Σ_b K_b (v² + ω² r_b²) bounds what the friction takes. Adhesion to dynamic
//        bodies is refused; its reaction is not computed.
// Law 5, stages divergence and pressure: in each iteration the samples of a dynamic body move with
//        boundary_velocity + Δt (a + α × (x_b − c)), a = F/M, α = I⁻¹ T from the pressure forces of that iteration,
//        F_b = Σ_i 2 m_i V_b κ_i ∇W_ib (N; 2: the wall stands for the mirrored liquid, divergence.hpp). A body lighter than the liquid that is taken for a wall while the pressure is
//        solved gets all the momentum of the liquid around it in one step and explodes; so the wall yields in the solve,
//        as the cloth does (Akinci et al. 2012 couple weakly; strong coupling after Gissler et al. 2019). At the end
//        v += Δt a, ω += Δt α.
// Law 6, stage density: the Jacobi diagonal counts the body by its absolute row sum, as the cloth's:
//        1/α_i += 0.3 · 4 Σ_b V_b (|∇W_ib| G/M + |r_b × ∇W_ib| H/I_min),  r_b = x_b − c,
//        G = Σ_b g_b, g_b = V_b Σ_i m_i |∇W_ib|;  H = Σ_b V_b Σ_i m_i |r_b × ∇W_ib|;  I_min the least moment of inertia,
//        the sums over b those of one body. For A_ij = Σ_b Σ_b' 4 V_b ∇W_ib·(1/M + [r_b]ᵀ I⁻¹ [r_b']) V_b' m_j ∇W_jb' this is a
//        bound of Σ_j |A_ij| (without the 0.3); with relaxation ω a share ω/2 of it is enough (Gershgorin).
// Law 7, stage time_step: mode cfl counts |v| + |ω| · (largest distance of the surface from c), of dynamic bodies
//        + |g| · time.step.
// Reads:  Model::bodies, Model::boundary, time, body_*.
// Writes: body_*, boundary_position, boundary_velocity.
