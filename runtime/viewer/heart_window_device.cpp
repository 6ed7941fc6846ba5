#include <QCheckBox>
#include <QComboBox>
#include <QFileDialog>
#include <QFormLayout>
#include <QHBoxLayout>
#include <QLineEdit>
#include <QPushButton>
#include <QSignalBlocker>
#include <QToolButton>

#include "runtime/app/play_device.h"
#include "runtime/base/error.h"
#include "runtime/viewer/device_choice.h"
#include "runtime/viewer/heart_window.h"

namespace beatlas::viewer {
namespace {

QString text(std::string_view words) {
  return QString::fromUtf8(words.data(), static_cast<int>(words.size()));
}

}  // namespace

void HeartWindow::make_devices(QFormLayout* form) {
  device_ = new QComboBox;
  device_->setObjectName("device");
  device_->setSizeAdjustPolicy(QComboBox::AdjustToMinimumContentsLengthWithIcon);
  device_->setMinimumContentsLength(10);
  for (const DeviceChoice& choice : kDevices) device_->addItem(text(choice.title));
  detail_ = new QLineEdit;
  detail_->setObjectName("device_detail");
  auto* browse = new QToolButton;
  browse->setText("...");
  connect_ = new QPushButton("Connect");
  connect_->setObjectName("device_connect");
  detail_row_ = new QWidget;
  auto* row = new QHBoxLayout(detail_row_);
  row->setContentsMargins(0, 0, 0, 0);
  row->addWidget(detail_, 1);
  row->addWidget(browse);
  detail_row_->hide();
  connect_->hide();
  form->addRow("Device", device_);
  form->addRow(detail_row_);
  form->addRow(connect_);
  connect(device_, qOverload<int>(&QComboBox::currentIndexChanged), this,
          [this] { device_chosen(); });
  connect(detail_, &QLineEdit::returnPressed, this, [this] { connect_device(); });
  connect(connect_, &QPushButton::clicked, this, [this] { connect_device(); });
  connect(browse, &QToolButton::clicked, this, [this] {
    const QString name = QFileDialog::getOpenFileName(this, detail_->placeholderText());
    if (!name.isEmpty()) detail_->setText(name);
  });
}

// The rows below the list, as the choice needs them.
void HeartWindow::show_device() {
  const DeviceChoice& choice = kDevices[static_cast<std::size_t>(device_->currentIndex())];
  detail_row_->setVisible(!choice.detail.empty());
  detail_row_->findChild<QToolButton*>()->setVisible(choice.detail_is_file);
  connect_->setVisible(device_->currentIndex() > 0);
  detail_->setPlaceholderText(text(choice.detail));
  detail_->setToolTip(text(choice.detail));
  touch_->setEnabled(live_ && device_->currentIndex() == 0);
}

void HeartWindow::device_chosen() {
  const DeviceChoice& choice = kDevices[static_cast<std::size_t>(device_->currentIndex())];
  const auto told = details_.find(device_->currentIndex());
  detail_->setText(told == details_.end() ? text(choice.usual) : told->second);
  touch_->setChecked(false);
  show_device();
  connecting_.drop();
  if (!live_) return;
  live_->use_mouse();  // a device in use is let go before it, or another, is opened
  lift_tool();
  say({});
  if (!choice.needs_detail || !detail_->text().isEmpty()) connect_device();
}

void HeartWindow::use_device(const std::string& name, const std::string& detail) {
  for (std::size_t n = 0; n < kDevices.size(); ++n) {
    if (kDevices[n].name != name) continue;
    if (!detail.empty()) details_[static_cast<int>(n)] = QString::fromStdString(detail);
    device_->setCurrentIndex(static_cast<int>(n));
  }
}

void HeartWindow::connect_device() {
  const DeviceChoice& choice = kDevices[static_cast<std::size_t>(device_->currentIndex())];
  if (!live_ || device_->currentIndex() == 0) return;
  if (choice.needs_detail && detail_->text().isEmpty()) {
    say(QString("%1: tell %2, then connect.").arg(text(choice.title), text(choice.detail)));
    return;
  }
  details_[device_->currentIndex()] = detail_->text();
  live_->use_mouse();
  lift_tool();
  const HeartFrame& frame = picture_->drawing()->frame();
  // The left ventricle's free wall, as a scripted press.
  const Vec3 direction = free_wall_direction(frame, heart_->touched->centre_mm());
  connecting_.begin([choice, detail = detail_->text().toStdString(), heart = *heart_, direction,
                     effusion_mm = options_.effusion_mm] {
    app::PlayArguments wanted = device_arguments(choice, detail);
    wanted.inside = heart.inside;
    wanted.effusion_mm = effusion_mm;
    app::SessionOptions session;
    ReadyDevice out;
    out.device =
        app::open_device(wanted, direction, *heart.touched, heart.atlas->manifest(), session);
    out.workspace_from_device = session.workspace_from_device;
    return out;
  });
  say(QString("%1: is it there? ...").arg(text(choice.title)));
}

// What moves each of several fingers, beside the window; all begin together.
void HeartWindow::open_fingers() {
  if (options_.fingers.empty()) return;
  opening_fingers_.begin([fingers = options_.fingers, heart = *heart_] {
    std::vector<ReadyDevice> out(fingers.size());
    for (std::size_t n = 0; n < fingers.size(); ++n) {
      if (fingers[n].device == "mouse") continue;
      app::SessionOptions session;
      try {
        out[n].device =
            app::open_device(fingers[n], *heart.touched, heart.atlas->manifest(), session);
      } catch (const Error& error) {
        throw error.with_context("finger " + std::to_string(n + 1));
      }
      out[n].workspace_from_device = session.workspace_from_device;
    }
    return out;
  });
}

void HeartWindow::take_fingers() {
  guard([&] {
    std::optional<std::vector<ReadyDevice>> ready = opening_fingers_.take();
    if (!ready || !live_) return;
    for (std::size_t n = 0; n < ready->size(); ++n) {
      if ((*ready)[n].device) live_->finger(n).use(std::move((*ready)[n]));
    }
  });
}

void HeartWindow::take_device() {
  try {
    std::optional<ReadyDevice> ready = connecting_.take();
    if (ready && live_) {
      live_->use(std::move(*ready));
      say({});
    }
  } catch (const std::exception& error) {
    say(QString("%1. The mouse moves the tool.").arg(error.what()));
    const QSignalBlocker quiet(device_);
    device_->setCurrentIndex(0);
    show_device();
  }
  if (!live_) return;
  // The other fingers have no mouse: theirs are only told.
  for (std::size_t n = 1; n < live_->touch().fingers(); ++n) {
    const std::string other = live_->finger(n).take_trouble();
    if (!other.empty()) say(QString("Finger %1: %2").arg(n + 1).arg(QString::fromStdString(other)));
  }
  const QString trouble = QString::fromStdString(live_->take_trouble());
  if (trouble.isEmpty()) return;
  say(trouble);
  lift_tool();
  const QSignalBlocker quiet(device_);
  device_->setCurrentIndex(0);
  show_device();
}

}  // namespace beatlas::viewer
