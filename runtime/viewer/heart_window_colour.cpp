#include <QCheckBox>
#include <QComboBox>
#include <QSlider>
#include <cmath>

#include "runtime/viewer/heart_window.h"

namespace beatlas::viewer {

// What hides the wall goes with its colours, and comes back without them.
void HeartWindow::colour_changed() {
  HeartDrawing* drawing = picture_->drawing();
  if (drawing == nullptr) return;
  guard([&] {
    const auto by = static_cast<ColourBy>(colour_->currentIndex());
    drawing->set_colouring(by, palpation::palpation_preset(preset_->currentText().toStdString()));
    for (const auto& [structure, widgets] : structures_) {
      const double opacity =
          by == ColourBy::Structure ? default_look(structure).opacity : coloured_opacity(structure);
      widgets.second->setValue(static_cast<int>(std::lround(100 * opacity)));
    }
    looks_changed();
  });
}

void HeartWindow::stiffness_changed() {
  HeartDrawing* drawing = picture_->drawing();
  if (drawing == nullptr || drawing->colouring() == nullptr) return;
  guard([&] {
    drawing->set_colouring(drawing->colouring()->by(),
                           palpation::palpation_preset(preset_->currentText().toStdString()));
  });
}

}  // namespace beatlas::viewer
