#include <QComboBox>
#include <QDoubleSpinBox>
#include <QFormLayout>
#include <QSignalBlocker>

#include "runtime/viewer/heart_window.h"

namespace beatlas::viewer {
namespace {

constexpr int kDecimals = 4;
constexpr double kLargest = 1e6;  // each has its own range, which is told where it is left

}  // namespace

void HeartWindow::make_constants(QFormLayout* form) {
  constant_ = new QComboBox;
  constant_->setObjectName("constant");
  constant_->setSizeAdjustPolicy(QComboBox::AdjustToMinimumContentsLengthWithIcon);
  constant_->setMinimumContentsLength(10);
  constant_value_ = new QDoubleSpinBox;
  constant_value_->setObjectName("constant_value");
  constant_value_->setDecimals(kDecimals);
  constant_value_->setRange(0, kLargest);
  constant_value_->setStepType(QAbstractSpinBox::AdaptiveDecimalStepType);
  constant_value_->setKeyboardTracking(false);
  form->addRow(constant_);  // its names are as long as the panel is wide
  form->addRow("Value", constant_value_);
  connect(constant_, qOverload<int>(&QComboBox::currentIndexChanged), this,
          [this] { show_constant(); });
  connect(constant_value_, qOverload<double>(&QDoubleSpinBox::valueChanged), this,
          [this](double value) {
            guard([&] {
              if (live_) live_->touch().set_constant(constant_->currentText().toStdString(), value);
              if (live_) show_pressures();
            });
            show_constant();  // as it was, where it was refused
          });
}

void HeartWindow::show_constant() {
  const QSignalBlocker quiet(constant_value_);
  const std::string name = constant_->currentText().toStdString();
  constant_->setToolTip("A number of muscle, circulation or disease: " + constant_->currentText());
  constant_value_->setEnabled(live_ && !name.empty());
  if (constant_value_->isEnabled()) constant_value_->setValue(live_->touch().constant(name));
}

void HeartWindow::list_constants() {
  const QSignalBlocker quiet(constant_);
  const QString before = constant_->currentText();
  constant_->clear();
  if (live_) {
    for (const std::string& name : live_->touch().constants()) {
      constant_->addItem(QString::fromStdString(name));
    }
  }
  const int at = constant_->findText(before);
  if (at >= 0) constant_->setCurrentIndex(at);
  show_constant();
}

}  // namespace beatlas::viewer
