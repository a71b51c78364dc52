#include "view/materials.hpp"

#include <vtkDataObject.h>
#include <vtkProperty.h>
#include <vtkShaderProperty.h>

#include "view_colors.hpp"  // made of tools/export/saturation.json

namespace drench {
namespace {

constexpr double water_color[3] = {0.13, 0.45, 0.80};

/// Vectors to the eye and to the key light, in the camera's frame, and the mirror's share (Schlick 1994).
constexpr const char* gloss_terms = R"(
  vec3 toEye = normalize(-vertexVC.xyz);
  vec3 halfway = normalize(normalize(vec3(-0.6, 1.0, 0.8)) + toEye);
  float facing = clamp(dot(normalVCVSOutput, toEye), 0.0, 1.0);
  float grazing = pow(1.0 - facing, 5.0);
  float glint = max(dot(normalVCVSOutput, halfway), 0.0);
)";

void plain(vtkActor* actor, double red, double green, double blue) {
  vtkProperty* p = actor->GetProperty();
  p->SetColor(red, green, blue);
  p->SetAmbient(0.22);
  p->SetDiffuse(0.85);
}

/// Adds to the light of each fragment.
void after_lights(vtkActor* actor, const std::string& code) {
  actor->GetShaderProperty()->AddFragmentShaderReplacement(
      "//VTK::Light::Impl", true, std::string("//VTK::Light::Impl\n{") + gloss_terms + code + "}\n", false);
}

}  // namespace

vtkSmartPointer<vtkColorTransferFunction> cloth_colors() {
  auto colors = vtkSmartPointer<vtkColorTransferFunction>::New();
  for (std::size_t i = 0; i + 3 < std::size(saturation_points); i += 4)
    colors->AddRGBPoint(saturation_points[i], saturation_points[i + 1], saturation_points[i + 2],
                        saturation_points[i + 3]);
  return colors;
}

vtkSmartPointer<vtkColorTransferFunction> field_colors(double low, double high) {
  static constexpr double viridis[][3] = {{0.267, 0.005, 0.329}, {0.275, 0.195, 0.496}, {0.213, 0.359, 0.552},
                                          {0.153, 0.497, 0.558}, {0.122, 0.633, 0.531}, {0.290, 0.759, 0.428},
                                          {0.622, 0.854, 0.226}, {0.993, 0.906, 0.144}};
  auto colors = vtkSmartPointer<vtkColorTransferFunction>::New();
  const double last = static_cast<double>(std::size(viridis)) - 1;
  if (!(high > low)) high = low + (low != 0 ? 1e-6 * std::abs(low) : 1);
  for (std::size_t i = 0; i < std::size(viridis); ++i)
    colors->AddRGBPoint(low + (high - low) * static_cast<double>(i) / last, viridis[i][0], viridis[i][1],
                        viridis[i][2]);
  return colors;
}

void make_cloth(vtkActor* actor, vtkPolyDataMapper* mapper, bool has_saturation) {
  plain(actor, saturation_points[1], saturation_points[2], saturation_points[3]);
  if (!has_saturation) return;
  mapper->MapDataArrayToVertexAttribute("wetMC", "saturation", vtkDataObject::FIELD_ASSOCIATION_POINTS, -1);
  vtkShaderProperty* shader = actor->GetShaderProperty();
  shader->AddVertexShaderReplacement("//VTK::PositionVC::Dec", true,
                                     "//VTK::PositionVC::Dec\nin float wetMC;\nout float wetVSOutput;\n", false);
  shader->AddVertexShaderReplacement("//VTK::PositionVC::Impl", true,
                                     "//VTK::PositionVC::Impl\n  wetVSOutput = wetMC;\n", false);
  shader->AddFragmentShaderReplacement("//VTK::PositionVC::Dec", true,
                                       "//VTK::PositionVC::Dec\nin float wetVSOutput;\n", false);
  after_lights(actor, R"(
  float wet = smoothstep(0.15, 1.0, wetVSOutput);
  float gloss = wet * (0.45 * pow(glint, 60.0) + 0.18 * pow(glint, 12.0)) + 0.55 * wet * grazing;
  gl_FragData[0].rgb += gloss * vec3(0.92, 0.96, 1.0);
)");
}

void make_water(vtkActor* hull, vtkActor* skin) {
  for (vtkActor* actor : {hull, skin}) {
    plain(actor, water_color[0], water_color[1], water_color[2]);
    actor->ForceOpaqueOn();  // in the order of the actors, and mixed with what is there
  }
  after_lights(hull, "gl_FragData[0] = vec4(0.0, 0.0, 0.0, 1e-3);");  // VTK throws away what is wholly clear
  after_lights(skin, R"(
  float mirror = pow(1.0 - facing, 3.0);
  vec3 lit = gl_FragData[0].rgb + 0.75 * pow(glint, 70.0) + 0.25 * grazing;
  gl_FragData[0] = vec4(lit, min(1.0, mix(0.58, 0.97, mirror) + 0.75 * pow(glint, 70.0)));
)");
}

void make_colored_liquid(vtkActor* actor) { plain(actor, water_color[0], water_color[1], water_color[2]); }

void make_body(vtkActor* actor) {
  plain(actor, 0.62, 0.63, 0.66);
  actor->GetProperty()->SetOpacity(0.45);
}

void make_container(vtkActor* edges) {
  plain(edges, 0.45, 0.45, 0.48);
  edges->GetProperty()->SetLineWidth(1.5);
}

}  // namespace drench
