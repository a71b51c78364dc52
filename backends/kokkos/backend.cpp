// The Kokkos backend behind the pipeline's interface: it owns the subsystems and hands each stage what it reads and
// writes.

#include <Kokkos_Profiling_ScopedRegion.hpp>
#include <algorithm>
#include <cmath>
#include <map>
#include <stdexcept>

#include "cloth/pins.hpp"
#include "cloth/stages.hpp"
#include "core/host_copy.hpp"
#include "core/neighbor_search.hpp"
#include "core/workspace.hpp"
#include "coupling/advection.hpp"
#include "coupling/body_response.hpp"
#include "coupling/forcing.hpp"
#include "fluid/lean_pressure.hpp"
#include "fluid/stages.hpp"
#include "pipeline/rank_memory.hpp"
#include "pipeline/runtime.hpp"
#include "porous/contact_wicking.hpp"
#include "porous/stages.hpp"
#include "porous/transfer.hpp"
#include "step/field_views.hpp"
#include "step/kept_state.hpp"
#include "step/stages.hpp"

namespace drench {
namespace kokkos_backend {
namespace {

class KokkosBackend final : public Backend {
 public:
  /// `workspace` is the current one.
  KokkosBackend(const Model& model, const Communicator* ranks, std::unique_ptr<Workspace> workspace)
      : workspace_(std::move(workspace)),
        constants_(model, ranks),
        fluid_(constants_),
        bodies_(constants_),
        cloth_(constants_) {
    for (CellTable* table : {&wet_adhesion_.cells, &measures_.cells}) *table = CellTable(model.scene.sort);
    take_applied(constants_, bodies_);
    aim_jets();
  }

  std::string name() const override { return "kokkos"; }
  std::string description() const override {
    const std::string transport = fluid_.exchange.transport();
    return runtime_description() + (transport.empty() ? "" : "particles travel by " + transport + "\n");
  }
  double pair_rounding() const override { return has_lean_pressure ? 0x1p-16 : 0; }
  void fence() override {
    const CurrentWorkspace here(*workspace_);
    exec().fence("drench::pipeline::timer");
  }

  void upload(const HostState& state) override {
    const CurrentWorkspace here(*workspace_);
    fluid_.exchange.upload_own(state, fluid_.particles);
    bodies_.upload(constants_, state);
    cloth_.upload(constants_.model, state);
    accounts_ = state;
    jets_.particles = state.jet_particles;
    jets_.particles.resize(constants_.model.jets.size(), 0);
  }

  HostState download() const override {
    const CurrentWorkspace here(*workspace_);
    HostState state;
    fluid_.particles.download(state);
    fluid_.exchange.gather(state);
    bodies_.download(constants_, state);
    cloth_.download(constants_.model, state);
    static_cast<Accounts&>(state) = accounts_;
    state.jet_particles = jets_.particles;
    return state;
  }

  void keep() override {
    const CurrentWorkspace here(*workspace_);
    kept_.keep(fluid_, bodies_, cloth_, accounts_, jets_);
  }
  void go_back() override {
    const CurrentWorkspace here(*workspace_);
    kept_.go_back(fluid_, bodies_, cloth_, accounts_, jets_);
  }

  std::vector<FieldView> fields() const override {
    const CurrentWorkspace here(*workspace_);
    exec().fence("drench::fields");
    return field_views(constants_.model, fluid_, bodies_, cloth_);
  }

  void model_changed() override {
    const CurrentWorkspace here(*workspace_);
    find_moving_pins(constants_.model, cloth_.nodes);
    take_applied(constants_, bodies_);
    aim_jets();
  }

  HostState body_states() const override {
    const CurrentWorkspace here(*workspace_);
    HostState state;
    bodies_.download_poses(constants_, state);
    return state;
  }
  std::vector<std::optional<BodyLoad>> body_loads(double dt) const override {
    const CurrentWorkspace here(*workspace_);
    return kokkos_backend::body_loads(constants_, bodies_, dt);
  }

  void run(Stage stage, const StepInfo& info, StepReport& report) override {
    const CurrentWorkspace here(*workspace_);
    Kokkos::Profiling::ScopedRegion region(std::string("drench::") + std::string(name_of(stage)));
    switch (stage) {
      case Stage::time_step:
        clear_given(bodies_);
        return time_step(constants_, fluid_, bodies_, cloth_, measured_, info, report);
      case Stage::prescribed_motion:
        return prescribed_motion(constants_, bodies_, info);
      case Stage::neighbors:
        neighbors(constants_, fluid_, lists_, bodies_, cloth_,
                  measured_.is_of(fluid_.particles.moved) ? &measured_.fluid : nullptr);
        report.imbalance = fluid_.exchange.imbalance();
        report.cuts = fluid_.exchange.cuts();
        return;
      case Stage::density:
        return density(constants_, fluid_, lists_, bodies_, cloth_, report);
      case Stage::divergence:
        return divergence(constants_, fluid_, lists_, bodies_, cloth_, pressure_, info, report);
      case Stage::forces:
        return forces(constants_, fluid_, lists_, bodies_, cloth_, forces_, info, report);
      case Stage::micropolar:
        return micropolar(constants_, fluid_, lists_, micropolar_, info, report);
      case Stage::surface_tension:
        return surface_tension(constants_, fluid_, lists_, bodies_, cloth_, surface_tension_, info);
      case Stage::wet_adhesion:
        return wet_adhesion(constants_, bodies_, cloth_, wet_adhesion_, info);
#define DRENCH_KOKKOS_FORCE(name, fastest) \
  case Stage::name:                        \
    return name({constants_, lists_, bodies_, fluid_, cloth_, info, force_work_[stage]});
        DRENCH_FORCES(DRENCH_KOKKOS_FORCE)
#undef DRENCH_KOKKOS_FORCE
      case Stage::cloth:
        return cloth(constants_, bodies_, cloth_, solver_, load_cloth_with_last_pressure(), info, report);
      case Stage::pressure:
        return pressure(constants_, fluid_, lists_, bodies_, cloth_, pressure_, solver_, info, report);
      case Stage::self_collision:
        return self_collision(constants_, bodies_, cloth_, self_collision_, info, report);
      case Stage::squeezing:
        return squeezing(constants_, bodies_, cloth_, solver_, self_collision_, squeezing_, info);
      case Stage::evaporation:
        return evaporation(constants_, fluid_, lists_, bodies_, cloth_, evaporation_, accounts_, info);
      case Stage::advection:
        return advection(constants_, fluid_, lists_, bodies_, cloth_, advection_, accounts_, info, report);
      case Stage::bodies:
        return bodies(constants_, bodies_, info);
      case Stage::jets:
        return jets(constants_, fluid_, jets_, accounts_, info);
      case Stage::porous_neighbors:
        return porous_neighbors(constants_, fluid_, lists_, bodies_, cloth_, diffusion_);
      case Stage::flow_direction:
        return flow_direction(constants_, lists_, bodies_, cloth_);
      case Stage::permeation:
        return permeation(constants_, fluid_, lists_, bodies_, cloth_, permeation_, info);
      case Stage::drying:
        return drying(constants_, fluid_, lists_, bodies_, cloth_, drying_, accounts_, info);
      case Stage::absorption:
        return absorption(constants_, fluid_, lists_, cloth_, transfers_, permeation_, absorption_, info);
      case Stage::emission:
        return emission(constants_, fluid_, lists_, bodies_, cloth_, transfers_, emission_, info);
      case Stage::diffusion:
        return diffusion(constants_, lists_, cloth_, diffusion_, contacts_, reservoirs_, accounts_, info, report);
      case Stage::reservoir:
        return reservoir(constants_, cloth_, reservoirs_, accounts_);
      case Stage::measures:
        return measures(constants_, fluid_, cloth_, measures_, report);
      case Stage::fabric:
        return fabric(constants_, cloth_, fabric_, report);
      case Stage::ledger:
        return ledger(constants_, fluid_, bodies_, cloth_, measured_, accounts_, info, report);
    }
  }

  std::vector<std::pair<Index, Index>> neighbor_pairs(const std::string& list) const override {
    const CurrentWorkspace here(*workspace_);
    const NeighborList& l = list_named(list);
    std::vector<std::pair<Index, Index>> pairs;
    const bool from_liquid = list.starts_with("fluid_"), to_liquid = list.ends_with("_fluid");
    const std::vector<Index> rank = fluid_.particles.ranks_by_id();
    const auto named = [&](Index i, bool liquid) { return liquid ? rank[static_cast<std::size_t>(i)] : i; };
    const std::vector<std::vector<Index>> rows = rows_on_host(l);
    for (Index i = 0; i < l.rows; ++i)
      for (const Index j : rows[static_cast<std::size_t>(i)])
        pairs.emplace_back(named(i, from_liquid), named(j, to_liquid));
    return pairs;
  }

 private:
  /// Uploads the mouths that have changed: a program that moves a body in each step changes none.
  void aim_jets() {
    const std::vector<Jet>& jets = constants_.model.jets;
    jets_.offsets.resize(jets.size());
    mouths_.resize(jets.size());
    for (std::size_t j = 0; j < jets.size(); ++j) {
      if (jets[j].mouth || mouths_[j] == jets[j].offsets) continue;
      mouths_[j] = jets[j].offsets;
      jets_.offsets[j] = to_device3("drench::jet_offsets", mouths_[j]);
    }
  }

  /// nodes.force of the pressure that the last density solve found; whether there is any.
  bool load_cloth_with_last_pressure() {
    if (fluid_.particles.total == 0 || cloth_.samples.count == 0) return false;
    warm_start_density(fluid_, pressure_);
    fluid_.exchange.halo(fluid_.particles.kappa_density);
    load_cloth({lists_.sheet_rows, fluid_.exchange, fluid_.particles.kappa_density}, cloth_);
    return true;
  }

  const NeighborList& list_named(const std::string& name) const {
    if (name == "fluid_fluid") return lists_.fluid_fluid;
    if (name == "fluid_boundary") return lists_.fluid_boundary;
    if (name == "fluid_sample") return lists_.fluid_sample;
    if (name == "sample_fluid") return lists_.sample_fluid;
    if (name == "sample_sample") return lists_.sample_sample;
    if (name == "sample_boundary") return lists_.sample_boundary;
    throw std::runtime_error("no neighbour list " + name);
  }

  std::unique_ptr<Workspace> workspace_;
  Constants constants_;
  // what a run computes with
  Fluid fluid_;
  Bodies bodies_;
  Cloth cloth_;
  NeighborLists lists_;
  Jets jets_;
  std::vector<std::vector<Vec3>> mouths_;  // on the host, of each jet
  Accounts accounts_;
  Cached<StateMeasures> measured_;
  KeptState kept_;
  // the stages' own work arrays, made on first use
  PressureWork pressure_;
  ForcesWork forces_;
  MicropolarWork micropolar_;
  SurfaceTensionWork surface_tension_;
  WetAdhesionWork wet_adhesion_;
  std::map<Stage, std::shared_ptr<void>> force_work_;
  ClothSolverWork solver_;
  SelfCollisionWork self_collision_;
  SqueezingWork squeezing_;
  EvaporationWork evaporation_;
  AdvectionWork advection_;
  TransferWork transfers_;
  PermeationWork permeation_;
  DryingWork drying_;
  AbsorptionWork absorption_;
  EmissionWork emission_;
  DiffusionWork diffusion_;
  ContactWork contacts_;
  ReservoirWork reservoirs_;
  MeasuresWork measures_;
  FabricWork fabric_;
};

}  // namespace
}  // namespace kokkos_backend

MemoryEstimate kokkos_array_bytes(const SetupSize& size, int real_bytes, bool gpu) {
  using namespace kokkos_backend;
  const Sizing sizing(size, real_bytes, gpu);
  MemoryEstimate sum;
  sum += particle_bytes(sizing);
  sum += body_bytes(sizing);
  sum += cloth_bytes(sizing);
  sum += neighbor_bytes(sizing);
  sum += body_neighbor_bytes(sizing);
  sum += density_bytes(sizing);
  sum += divergence_bytes(sizing);
  sum += forces_bytes(sizing);
  sum += micropolar_bytes(sizing);
  sum += surface_tension_bytes(sizing);
  sum += wet_adhesion_bytes(sizing);
#define DRENCH_KOKKOS_FORCE(name, fastest) sum += name##_bytes(sizing);
  DRENCH_FORCES(DRENCH_KOKKOS_FORCE)
#undef DRENCH_KOKKOS_FORCE
  sum += cloth_solver_bytes(sizing);
  sum += pressure_bytes(sizing);
  sum += self_collision_bytes(sizing);
  sum += squeezing_bytes(sizing);
  sum += evaporation_bytes(sizing);
  sum += advection_bytes(sizing);
  sum += porous_neighbor_bytes(sizing);
  sum += transfer_bytes(sizing);
  sum += permeation_bytes(sizing);
  sum += drying_bytes(sizing);
  sum += absorption_bytes(sizing);
  sum += emission_bytes(sizing);
  sum += diffusion_bytes(sizing);
  sum += contact_wicking_bytes(sizing);
  sum += measures_bytes(sizing);
  sum += fabric_bytes(sizing);
  sum += ledger_bytes(sizing);
  sum += kept_state_bytes(sizing);
  return sum;
}

MemoryEstimate kokkos_rank_bytes(const SetupSize& scene, double owned, double ghosts, int real_bytes, bool gpu) {
  constexpr double ample = 1.25;  // of ParticleSet::reserve, which a rank's own particles come to first
  const double local = owned + ghosts;
  SetupSize size = scene;
  size.adds_particles = true;  // they come from other ranks
  size.fluid = local > ample * owned ? local : owned;
  MemoryEstimate sum = kokkos_array_bytes(size, real_bytes, gpu);
  size.fluid = local;
  if (scene.samples <= 0 && size.fluid_cells > std::max(65536.0, 8 * local))  // CellTable::make_keys
    size.fluid_cells = std::max(1024.0, std::exp2(std::ceil(std::log2(2 * local))));
  sum.cells = kokkos_array_bytes(size, real_bytes, gpu).cells;
  if (scene.samples <= 0) size.fluid = owned;  // ghosts near cloth have rows
  sum.lists = kokkos_array_bytes(size, real_bytes, gpu).lists;
  sum.particles += kokkos_backend::exchange_bytes(owned, ghosts, real_bytes);
  return sum;
}

std::unique_ptr<Backend> make_kokkos_backend(const Model& model) { return make_kokkos_backend_on(nullptr, model); }

std::unique_ptr<Backend> make_kokkos_backend_on(const Communicator* ranks, const Model& model) {
  using namespace kokkos_backend;
  auto workspace = std::make_unique<Workspace>(new_space());
  const CurrentWorkspace here(*workspace);
  return std::make_unique<KokkosBackend>(model, ranks, std::move(workspace));
}

}  // namespace drench
