#include "view/picture.hpp"

#include <fmt/format.h>
#include <vtkCellData.h>
#include <vtkDataSetSurfaceFilter.h>
#include <vtkFeatureEdges.h>
#include <vtkFloatArray.h>
#include <vtkLight.h>
#include <vtkNew.h>
#include <vtkOpenGLSphereMapper.h>
#include <vtkPointData.h>
#include <vtkPolyDataNormals.h>
#include <vtkProperty.h>
#include <vtkTextProperty.h>
#include <vtkThreshold.h>

#include <algorithm>

#include "view/materials.hpp"

namespace drench {
namespace {

constexpr double ink[3] = {0.15, 0.15, 0.18};
constexpr double ball = 1.12;  // radii: neighbours close into a surface

void add_lights(vtkRenderer* renderer) {
  static constexpr double lights[][4] = {{-0.6, 1.0, 0.8, 0.85}, {0.9, 0.5, 0.6, 0.30}, {0.2, -1.0, 0.5, 0.55}};
  renderer->AutomaticLightCreationOff();
  for (const auto& l : lights) {
    vtkNew<vtkLight> light;
    light->SetLightTypeToCameraLight();
    light->SetPosition(l[0], l[1], l[2]);
    light->SetFocalPoint(0, 0, 0);
    light->SetIntensity(l[3]);
    renderer->AddLight(light);
  }
}

void set_ink(vtkTextProperty* text) {
  text->SetColor(ink[0], ink[1], ink[2]);
  text->BoldOff();
  text->ItalicOff();
  text->ShadowOff();
}

vtkSmartPointer<vtkPolyData> skin_of(vtkUnstructuredGrid* grid) {
  vtkNew<vtkDataSetSurfaceFilter> skin;
  skin->SetInputData(grid);
  skin->Update();
  return skin->GetOutput();
}

/// The cells whose fields container and plane are these.
vtkSmartPointer<vtkUnstructuredGrid> cells_with(vtkUnstructuredGrid* grid, bool container, bool plane) {
  vtkSmartPointer<vtkUnstructuredGrid> part = grid;
  for (const auto& [name, value] : {std::pair{"container", container}, std::pair{"plane", plane}}) {
    if (!part->GetCellData()->HasArray(name)) continue;
    vtkNew<vtkThreshold> threshold;
    threshold->SetInputData(part);
    threshold->SetInputArrayToProcess(0, 0, 0, vtkDataObject::FIELD_ASSOCIATION_CELLS, name);
    threshold->SetThresholdFunction(vtkThreshold::THRESHOLD_BETWEEN);
    threshold->SetLowerThreshold(value ? 0.5 : -0.5);
    threshold->SetUpperThreshold(value ? 1.5 : 0.5);
    threshold->Update();
    part = threshold->GetOutput();
  }
  return part;
}

/// A vertex for each particle, with the radius that it is drawn with.
vtkSmartPointer<vtkPolyData> balls_of(vtkUnstructuredGrid* grid) {
  auto points = vtkSmartPointer<vtkPolyData>::New();
  points->SetPoints(grid->GetPoints());
  points->SetVerts(grid->GetCells());  // without cells nothing is drawn
  points->GetPointData()->ShallowCopy(grid->GetPointData());
  if (vtkDataArray* radius = grid->GetPointData()->GetArray("radius")) {
    auto shown = vtkSmartPointer<vtkFloatArray>::New();
    shown->SetName("shown_radius");
    shown->SetNumberOfTuples(radius->GetNumberOfTuples());
    for (vtkIdType i = 0; i < radius->GetNumberOfTuples(); ++i)
      shown->SetValue(i, static_cast<float>(ball * radius->GetTuple1(i)));
    points->GetPointData()->AddArray(shown);
  }
  return points;
}

vtkSmartPointer<vtkPolyDataMapper> mapper_of(vtkPolyData* data, bool balls) {
  vtkSmartPointer<vtkPolyDataMapper> mapper;
  if (balls) {
    auto spheres = vtkSmartPointer<vtkOpenGLSphereMapper>::New();
    spheres->SetScaleArray("shown_radius");
    mapper = spheres;
  } else {
    mapper = vtkSmartPointer<vtkPolyDataMapper>::New();
  }
  mapper->SetInputData(data);
  mapper->ScalarVisibilityOff();
  return mapper;
}

/// The surface with a normal at each point.
vtkSmartPointer<vtkPolyData> smooth_skin_of(vtkUnstructuredGrid* grid) {
  vtkSmartPointer<vtkPolyData> skin = skin_of(grid);
  if (skin->GetPointData()->GetNormals()) return skin;
  vtkNew<vtkPolyDataNormals> normals;
  normals->SetInputData(skin);
  normals->SplittingOff();
  normals->ConsistencyOff();  // meshes are, and sorting them costs more than the rest
  normals->Update();
  return normals->GetOutput();
}

}  // namespace

Picture::Picture()
    : renderer_(vtkSmartPointer<vtkRenderer>::New()),
      time_(vtkSmartPointer<vtkTextActor>::New()),
      bar_(vtkSmartPointer<vtkScalarBarActor>::New()),
      cloth_colors_(cloth_colors()) {
  renderer_->SetBackground(1, 1, 1);
  add_lights(renderer_);
  set_ink(time_->GetTextProperty());
  renderer_->AddActor2D(time_);
  bar_->SetNumberOfLabels(4);
  bar_->UnconstrainedFontSizeOn();
  bar_->SetVerticalTitleSeparation(8);
  bar_->VisibilityOff();
  for (vtkTextProperty* text : {bar_->GetTitleTextProperty(), bar_->GetLabelTextProperty()}) set_ink(text);
  renderer_->AddActor2D(bar_);
}

void Picture::fit_texts(int width, int height) {
  time_->GetTextProperty()->SetFontSize(std::max(12, height / 34));
  time_->SetPosition(width / 40.0, height / 40.0);
  for (vtkTextProperty* text : {bar_->GetTitleTextProperty(), bar_->GetLabelTextProperty()})
    text->SetFontSize(std::max(11, height / 48));
  bar_->SetPosition(0.87, 0.06);
  bar_->SetWidth(0.1);
  bar_->SetHeight(0.34);
}

void Picture::color_by(std::optional<FieldRange> field) {
  field_ = std::move(field);
  if (field_) field_colors_ = field_colors(field_->low, field_->high);
}

void Picture::show(const Moment& moment) {
  for (const auto& actor : actors_) renderer_->RemoveActor(actor);
  actors_.clear();
  if (moment.cloth) add_cloth(moment.cloth);
  for (const auto& grid : moment.bodies) add_bodies(grid);
  add_liquid(moment);  // last: the rest shows through it
  time_->SetInput(fmt::format("t = {:.3f} s", moment.time).c_str());
  const bool wetting = !field_ && moment.cloth && moment.cloth->GetPointData()->HasArray("saturation");
  bar_->SetVisibility(field_ || wetting);
  if (!field_ && !wetting) return;
  const std::string name = field_ ? field_->name : "saturation", unit = unit_of(name);
  bar_->SetTitle((unit.empty() ? name : name + "\n" + unit).c_str());
  bar_->SetLookupTable(field_ ? field_colors_ : cloth_colors_);
  bar_->SetLabelFormat(field_ ? "%.4g" : "%.1f");
}

vtkActor* Picture::add(vtkPolyDataMapper* mapper) {
  auto actor = vtkSmartPointer<vtkActor>::New();
  actor->SetMapper(mapper);
  renderer_->AddActor(actor);
  actors_.push_back(actor);
  return actor;
}

bool Picture::colored(vtkUnstructuredGrid* grid) const {
  return field_ && grid && grid->GetPointData()->HasArray(field_->name.c_str());
}

bool Picture::color(vtkPolyDataMapper* mapper, vtkUnstructuredGrid* grid) const {
  if (!colored(grid)) return false;
  const int components = grid->GetPointData()->GetArray(field_->name.c_str())->GetNumberOfComponents();
  mapper->ScalarVisibilityOn();
  mapper->SetScalarModeToUsePointFieldData();
  mapper->SelectColorArray(field_->name.c_str());
  field_colors_->SetVectorModeToMagnitude();
  if (components == 1) field_colors_->SetVectorModeToComponent();
  mapper->SetLookupTable(field_colors_);
  mapper->UseLookupTableScalarRangeOn();
  return true;
}

void Picture::add_cloth(vtkUnstructuredGrid* grid) {
  if (grid->GetNumberOfPoints() == 0) return;
  const auto mapper = mapper_of(smooth_skin_of(grid), false);
  vtkActor* actor = add(mapper);
  const bool wets = !field_ && grid->GetPointData()->HasArray("saturation");
  make_cloth(actor, mapper, wets);
  if (color(mapper, grid) || !wets) return;
  mapper->ScalarVisibilityOn();
  mapper->SetScalarModeToUsePointFieldData();
  mapper->SelectColorArray("saturation");
  mapper->SetLookupTable(cloth_colors_);
  mapper->UseLookupTableScalarRangeOn();
}

void Picture::add_liquid(const Moment& moment) {
  const bool field_of_particles_only = colored(moment.fluid) && !colored(moment.surface);
  const bool surface = moment.surface && surface_ && !field_of_particles_only;
  vtkUnstructuredGrid* grid = surface ? moment.surface : moment.fluid;
  if (!grid || grid->GetNumberOfPoints() == 0) return;
  const auto data = surface ? smooth_skin_of(grid) : balls_of(grid);
  const auto mapper = mapper_of(data, !surface);
  vtkActor* actor = add(mapper);
  if (color(mapper, grid))
    make_colored_liquid(actor);
  else
    make_water(actor, add(mapper_of(data, !surface)));
}

void Picture::add_bodies(vtkUnstructuredGrid* grid) {
  if (const auto container = cells_with(grid, true, false); container->GetNumberOfCells() > 0) {
    vtkNew<vtkFeatureEdges> edges;
    edges->SetInputData(skin_of(container));
    edges->SetFeatureAngle(20);
    edges->ColoringOff();
    edges->Update();
    make_container(add(mapper_of(edges->GetOutput(), false)));
  }
  for (const bool plane : {true, false}) {
    const auto part = cells_with(grid, false, plane);
    if (part->GetNumberOfCells() == 0) continue;
    vtkNew<vtkPolyDataNormals> normals;
    normals->SetInputData(skin_of(part));
    normals->SetFeatureAngle(40);
    normals->Update();
    vtkActor* actor = add(mapper_of(normals->GetOutput(), false));
    make_body(actor);
    if (plane) actor->GetProperty()->BackfaceCullingOn();  // a floor does not hide what a camera under it looks at
  }
}

}  // namespace drench
