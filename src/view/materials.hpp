#pragma once
// How water, cloth and bodies look. The shaders add to VTK's own; they hold for VTK 9.1 and later.

#include <vtkActor.h>
#include <vtkColorTransferFunction.h>
#include <vtkPolyDataMapper.h>
#include <vtkSmartPointer.h>

namespace drench {

/// Dry cloth to soaked cloth, over saturation: tools/export/saturation.json.
vtkSmartPointer<vtkColorTransferFunction> cloth_colors();
/// Dark blue to yellow (viridis) from `low` to `high`.
vtkSmartPointer<vtkColorTransferFunction> field_colors(double low, double high);

/// Cloth, its colour from the mapper's scalars; glossy where the point field `saturation` is high.
void make_cloth(vtkActor* actor, vtkPolyDataMapper* mapper, bool has_saturation);

/// The two layers of water: `hull` hides what lies behind its foremost surface, `skin` colours that surface, clear
/// where it is seen at right angles. Both are to be drawn after everything that shows through, in this order.
void make_water(vtkActor* hull, vtkActor* skin);

/// Liquid that is coloured by a field: opaque.
void make_colored_liquid(vtkActor* actor);

void make_body(vtkActor* actor);
void make_container(vtkActor* edges);

}  // namespace drench
