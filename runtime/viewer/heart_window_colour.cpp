#include <QCheckBox>
#include <QComboBox>
#include <QSlider>
#include <QStandardItemModel>
#include <cmath>

#include "runtime/viewer/heart_window.h"

namespace beatlas::viewer {

palpation::PalpationParameters HeartWindow::chosen_parameters() const {
  const std::string name = preset_->currentText().toStdString();
  return options_.told && name == options_.told_name ? options_.told->parameters
                                                     : palpation::palpation_preset(name);
}

// Of the list of diseases.
void HeartWindow::preset_chosen(const QString& name) {
  guard([&] {
    if (!live_) return;
    if (told_disease_ && name.toStdString() == options_.told_name) {
      live_->touch().set_disease(*told_disease_);
    } else {
      live_->touch().set_preset(name.toStdString());
    }
    if (name != "healthy") model_->setCurrentIndex(1);  // a spring knows no disease
    show_pressures();
  });
}

// Of the list of colourings those that the package has something for.
void HeartWindow::show_colourings() {
  const HeartDrawing& drawing = *picture_->drawing();
  auto* list = qobject_cast<QStandardItemModel*>(colour_->model());
  bool any = false;
  for (int n = 0; n < colour_->count(); ++n) {
    const auto by = static_cast<ColourBy>(n);
    const bool has = drawing.can_colour_by(by);
    list->item(n)->setEnabled(has);
    any = any || (has && by != ColourBy::Structure);
  }
  colour_->setEnabled(any);
}

// What hides the wall goes with its colours, and comes back without them.
void HeartWindow::colour_changed() {
  HeartDrawing* drawing = picture_->drawing();
  if (drawing == nullptr) return;
  guard([&] {
    const auto by = static_cast<ColourBy>(colour_->currentIndex());
    drawing->set_colouring(by, chosen_parameters());
    for (const auto& [structure, widgets] : structures_) {
      const double opacity = by == ColourBy::Structure ? default_look(structure).opacity
                                                       : coloured_opacity(by, structure);
      widgets.second->setValue(static_cast<int>(std::lround(100 * opacity)));
    }
    looks_changed();
  });
}

void HeartWindow::stiffness_changed() {
  HeartDrawing* drawing = picture_->drawing();
  if (drawing == nullptr || drawing->colouring() == nullptr) return;
  guard([&] { drawing->set_colouring(drawing->colouring()->by(), chosen_parameters()); });
}

}  // namespace beatlas::viewer
