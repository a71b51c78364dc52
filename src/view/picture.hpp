#pragma once
// A run's moment as actors of a renderer, with its time and a bar of colours.

#include <vtkActor.h>
#include <vtkColorTransferFunction.h>
#include <vtkPolyDataMapper.h>
#include <vtkRenderer.h>
#include <vtkScalarBarActor.h>
#include <vtkSmartPointer.h>
#include <vtkTextActor.h>

#include <optional>
#include <string>
#include <vector>

#include "view/frame_fields.hpp"
#include "view/run_frames.hpp"

namespace drench {

class Picture {
 public:
  Picture();
  vtkRenderer* renderer() const { return renderer_; }

  /// The field that colours whatever has it; none: the plain look.
  void color_by(std::optional<FieldRange> field);
  /// The liquid's surface where the moment has one, or its particles.
  void show_surface(bool surface) { surface_ = surface; }
  /// Makes the actors of a moment anew.
  void show(const Moment& moment);
  /// Fits the texts to a picture of this many pixels.
  void fit_texts(int width, int height);

 private:
  vtkActor* add(vtkPolyDataMapper* mapper);
  void add_cloth(vtkUnstructuredGrid* grid);
  void add_liquid(const Moment& moment);
  void add_bodies(vtkUnstructuredGrid* grid);
  /// Colours what `mapper` shows by the field. False where it does not have it.
  bool color(vtkPolyDataMapper* mapper, vtkUnstructuredGrid* grid) const;
  bool colored(vtkUnstructuredGrid* grid) const;

  vtkSmartPointer<vtkRenderer> renderer_;
  std::vector<vtkSmartPointer<vtkActor>> actors_;
  vtkSmartPointer<vtkTextActor> time_;
  vtkSmartPointer<vtkScalarBarActor> bar_;
  vtkSmartPointer<vtkColorTransferFunction> cloth_colors_, field_colors_;
  std::optional<FieldRange> field_;
  bool surface_ = true;
};

}  // namespace drench
