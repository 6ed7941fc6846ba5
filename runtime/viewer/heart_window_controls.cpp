#include <QCheckBox>
#include <QComboBox>
#include <QFormLayout>
#include <QGroupBox>
#include <QHBoxLayout>
#include <QLabel>
#include <QPixmap>
#include <QPushButton>
#include <QScrollArea>
#include <QScrollBar>
#include <QSlider>
#include <QSpinBox>
#include <QSplitter>
#include <QStatusBar>
#include <QToolButton>
#include <QVBoxLayout>
#include <cmath>

#include "runtime/atlas/structure_colours.h"
#include "runtime/viewer/heart_window.h"

namespace beatlas::viewer {
namespace {

constexpr int kPhaseSteps = 1000;

QSlider* slider(const char* name, int low, int high, int value) {
  auto* made = new QSlider(Qt::Horizontal);
  made->setObjectName(name);
  made->setRange(low, high);
  made->setValue(value);
  return made;
}

QSpinBox* number(const char* name, int low, int high, const char* unit) {
  auto* made = new QSpinBox;
  made->setObjectName(name);
  made->setRange(low, high);
  made->setSuffix(unit);
  made->setKeyboardTracking(false);
  return made;
}

QComboBox* choice(const char* name, const QStringList& words) {
  auto* made = new QComboBox;
  made->setObjectName(name);
  made->setSizeAdjustPolicy(QComboBox::AdjustToMinimumContentsLengthWithIcon);
  made->setMinimumContentsLength(10);
  made->addItems(words);
  return made;
}

template <class Names>
QStringList words_of(const Names& names) {
  QStringList words;
  for (const auto& name : names) words << QString::fromStdString(std::string(name));
  return words;
}

}  // namespace

void HeartWindow::make_controls() {
  picture_ = new HeartWidget;
  picture_->setObjectName("picture");
  plots_ = new PlotWidget;
  plots_->setObjectName("plots");
  make_messages();
  auto* column = new QVBoxLayout;
  make_exercise(column);
  make_beat(column);
  make_cut(column);
  make_structures(column);
  make_touch(column);
  column->addStretch(1);
  lay_out(column);
}

void HeartWindow::make_messages() {
  message_ = new QLabel;
  message_->setObjectName("message");
  message_->setWordWrap(true);
  auto* dismiss = new QToolButton;
  dismiss->setObjectName("dismiss");
  dismiss->setText(QString::fromUtf8("\u2715"));
  dismiss->setToolTip("Hide this sentence");
  connect(dismiss, &QToolButton::clicked, this, [this] { say({}); });
  message_row_ = new QWidget;
  message_row_->setStyleSheet("background: #7a3b12; color: white;");
  auto* message_line = new QHBoxLayout(message_row_);
  message_line->setContentsMargins(8, 4, 4, 4);
  message_line->addWidget(message_, 1);
  message_line->addWidget(dismiss, 0, Qt::AlignTop);
  message_row_->hide();
  told_ = new QLabel;
  told_->setObjectName("told");
  told_->setSizePolicy(QSizePolicy::Ignored, QSizePolicy::Preferred);  // a window may be small
  statusBar()->addWidget(told_, 1);
}

void HeartWindow::make_beat(QVBoxLayout* column) {
  play_ = new QPushButton("Pause");
  play_->setObjectName("play");
  play_->setCheckable(true);
  play_->setChecked(true);
  rate_ = number("rate", 30, 220, " /min");
  phase_ = slider("phase", 0, kPhaseSteps, 0);
  view_ = choice("view", words_of(kViews));
  volume_ = choice("volume", {"off", "muscle", "blood"});
  colour_ = choice("colour",
                   {"structures", "wall thickness", "stiffness", "AHA segments", "uncertainty"});
  auto* beat = new QGroupBox("Beat and view");
  auto* beat_form = new QFormLayout(beat);
  beat_form->addRow(play_);
  beat_form->addRow("Heart rate", rate_);
  beat_form->addRow("Phase", phase_);
  beat_form->addRow("View", view_);
  beat_form->addRow("Volume", volume_);
  beat_form->addRow("Colour", colour_);
  column->addWidget(beat);
}

void HeartWindow::make_cut(QVBoxLayout* column) {
  QStringList cuts{"none"};
  cuts << words_of(kCuts) << "free";
  cut_ = choice("cut", cuts);
  cut_offset_ = slider("cut_offset", -kCutReachMm, kCutReachMm, 0);
  cut_image_ = new QCheckBox("Image on the cut");
  cut_image_->setObjectName("cut_image");
  cut_image_->setChecked(true);
  auto* cutting = new QGroupBox("Cut");
  auto* cut_form = new QFormLayout(cutting);
  cut_form->addRow("Plane", cut_);
  cut_form->addRow("Move", cut_offset_);
  cut_form->addRow(cut_image_);
  column->addWidget(cutting);
}

void HeartWindow::make_touch(QVBoxLayout* column) {
  touch_ = new QCheckBox("Touch with the mouse");
  touch_->setObjectName("touch");
  stiffness_ = number("stiffness", 10, 1000, " N/m");
  model_ = choice("model", {"spring", "muscle"});
  model_->setToolTip("A spring of the stiffness, or paper B's muscle: of the place, and as ill");
  left_atrium_ = number("lap", 0, 40, " mmHg");
  right_atrium_ = number("rap", 0, 40, " mmHg");
  preset_ = choice("preset", words_of(palpation::palpation_presets()));
  if (options_.told) {
    preset_->insertItem(0, QString::fromStdString(options_.told_name));
    preset_->setCurrentIndex(0);
  }
  reset_ = new QPushButton("Reset");
  reset_->setObjectName("reset");
  auto* feel = new QGroupBox("Touch and circulation");
  auto* feel_form = new QFormLayout(feel);
  make_devices(feel_form);
  feel_form->addRow(touch_);
  feel_form->addRow("Force", model_);
  feel_form->addRow("Stiffness", stiffness_);
  feel_form->addRow("Left atrium", left_atrium_);
  feel_form->addRow("Right atrium", right_atrium_);
  feel_form->addRow("Disease", preset_);
  make_constants(feel_form);
  feel_form->addRow(reset_);
  column->addWidget(feel);
}

void HeartWindow::lay_out(QVBoxLayout* column) {
  auto* controls = new QWidget;
  controls->setLayout(column);
  leave_wheel_to_panel(*controls);
  auto* scroll = new QScrollArea;  // a low window keeps its controls
  scroll->setWidget(controls);
  scroll->setWidgetResizable(true);
  scroll->setHorizontalScrollBarPolicy(Qt::ScrollBarAlwaysOff);
  scroll->setMinimumWidth(controls->minimumSizeHint().width() +
                          scroll->verticalScrollBar()->sizeHint().width());
  controls_ = scroll;
  splitter_ = new QSplitter;
  splitter_->addWidget(scroll);
  splitter_->addWidget(picture_);
  splitter_->addWidget(plots_);
  splitter_->setSizes({270, 620, 290});
  splitter_->setStretchFactor(1, 1);
  auto* whole = new QWidget;
  auto* rows = new QVBoxLayout(whole);
  rows->setContentsMargins(0, 0, 0, 0);
  rows->addWidget(message_row_);
  rows->addWidget(splitter_, 1);
  setCentralWidget(whole);
  setMinimumSize(200, 150);
}

void HeartWindow::leave_wheel_to_panel(const QWidget& panel) {
  for (QWidget* widget : panel.findChildren<QWidget*>()) {
    const bool scrolls = qobject_cast<QScrollBar*>(widget) != nullptr;
    const bool turns = qobject_cast<QComboBox*>(widget) != nullptr ||
                       qobject_cast<QAbstractSpinBox*>(widget) != nullptr ||
                       qobject_cast<QAbstractSlider*>(widget) != nullptr;
    if (!turns || scrolls) continue;
    widget->installEventFilter(this);
    if (widget->focusPolicy() == Qt::WheelFocus) widget->setFocusPolicy(Qt::StrongFocus);
  }
}

void HeartWindow::connect_controls() {
  connect_beat();
  connect(volume_, qOverload<int>(&QComboBox::currentIndexChanged), this, [this](int preset) {
    HeartDrawing* drawing = picture_->drawing();
    if (drawing != nullptr) drawing->set_volume(static_cast<VolumePreset>(preset));
  });
  connect(colour_, &QComboBox::currentTextChanged, this, [this] { colour_changed(); });
  connect(preset_, &QComboBox::currentTextChanged, this, [this] { stiffness_changed(); });
  connect(cut_, &QComboBox::currentTextChanged, this, [this] { cut_changed(); });
  connect(cut_offset_, &QSlider::valueChanged, this, [this](int mm) {
    cut_offset_mm_ = mm;
    cut_changed();
  });
  connect(cut_image_, &QCheckBox::toggled, this, [this] { cut_changed(); });
  connect_touch();
  connect_force();
  connect(preset_, &QComboBox::currentTextChanged, this,
          [this](const QString& name) { preset_chosen(name); });
  connect(reset_, &QPushButton::clicked, this, [this] { reset(); });
}

void HeartWindow::connect_beat() {
  connect(play_, &QPushButton::toggled, this, [this](bool on) { set_playing(on); });
  connect(rate_, qOverload<int>(&QSpinBox::valueChanged), this, [this](int per_min) {
    guard([&] {
      if (live_) live_->touch().set_heart_rate(per_min);
    });
  });
  connect(phase_, &QSlider::valueChanged, this, [this](int step) {
    const double phase = static_cast<double>(step) / kPhaseSteps;
    own_beats_ = phase;
    set_playing(false);
    // Held: the heart beats on to it and stays there.
    if (live_) {
      live_->touch().set_paused(false);
      live_->touch().hold_phase(std::min(phase, 0.999999));
    }
  });
  connect(view_, &QComboBox::currentTextChanged, this, [this](const QString& name) {
    HeartDrawing* drawing = picture_->drawing();
    if (drawing != nullptr) {
      drawing->fit_camera(standard_view(drawing->frame(), name.toStdString()));
    }
  });
}

void HeartWindow::connect_touch() {
  connect(touch_, &QCheckBox::toggled, this, [this](bool on) {
    picture_->set_touching(on);
    if (!on) lift_tool();
  });
  picture_->on_tool_put = [this](const Vec3& position_mm) { put_tool(position_mm); };
  picture_->on_tool = [this](const Vec3& position_mm) {
    if (live_) live_->mouse().move_to(position_mm);
    if (exercise_) exercise_->mouse().move_to(position_mm);
  };
}

void HeartWindow::connect_force() {
  connect(stiffness_, qOverload<int>(&QSpinBox::valueChanged), this, [this](int n_per_m) {
    guard([&] {
      if (live_) live_->touch().set_stiffness(n_per_m);
    });
  });
  connect(left_atrium_, qOverload<int>(&QSpinBox::valueChanged), this, [this](int mmhg) {
    guard([&] {
      if (live_) live_->touch().set_left_atrial_mmhg(mmhg);
      show_constant();
    });
  });
  connect(right_atrium_, qOverload<int>(&QSpinBox::valueChanged), this, [this](int mmhg) {
    guard([&] {
      if (live_) live_->touch().set_right_atrial_mmhg(mmhg);
      show_constant();
    });
  });
  connect(model_, qOverload<int>(&QComboBox::currentIndexChanged), this, [this](int model) {
    stiffness_->setEnabled(model == 0);
    guard([&] {
      if (live_) live_->touch().set_model(model == 1 ? "patch" : "proxy");
    });
  });
}

void HeartWindow::show_pressures() {
  const palpation::CirculationParameters& now = live_->touch().parameters().circulation;
  const QSignalBlocker quiet_left(left_atrium_);
  const QSignalBlocker quiet_right(right_atrium_);
  left_atrium_->setValue(static_cast<int>(std::lround(now.left_atrial_mmhg)));
  right_atrium_->setValue(static_cast<int>(std::lround(now.right_atrial_mmhg)));
  list_constants();
}

void HeartWindow::make_structures(QVBoxLayout* column) {
  auto* group = new QGroupBox("Structures: seen, opaque");
  auto* form = new QFormLayout(group);
  for (const Structure structure : kAllStructures) {
    const std::string name(structure_name(structure));
    auto* seen = new QCheckBox(QString::fromStdString(structure_title(structure)));
    seen->setObjectName(QString::fromStdString("show_" + name));
    const Colour colour = structure_colour(structure);
    QPixmap swatch(seen->iconSize());
    swatch.fill(QColor(colour[0], colour[1], colour[2]));
    seen->setIcon(swatch);
    auto* opacity = slider(("opacity_" + name).c_str(), 0, 100, 100);
    form->addRow(seen);
    form->addRow(opacity);
    structures_[structure] = {seen, opacity};
    connect(seen, &QCheckBox::toggled, this, [this] { looks_changed(); });
    connect(opacity, &QSlider::valueChanged, this, [this] { looks_changed(); });
  }
  column->addWidget(group);
}

}  // namespace beatlas::viewer
