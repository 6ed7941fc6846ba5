#include <QAction>
#include <QCheckBox>
#include <QComboBox>
#include <QFileDialog>
#include <QFormLayout>
#include <QGroupBox>
#include <QLabel>
#include <QMenu>
#include <QMenuBar>
#include <QMessageBox>
#include <QPushButton>
#include <QScrollArea>
#include <QSettings>
#include <QShortcut>
#include <QSlider>
#include <QSpinBox>
#include <QSplitter>
#include <QStatusBar>
#include <QVBoxLayout>
#include <cmath>

#include "runtime/viewer/heart_window.h"

namespace beatlas::viewer {
namespace {

constexpr int kPhaseSteps = 1000;

const char* const kKeys =
    "Mouse\n"
    "  drag: turn    right drag or wheel: zoom    shift or middle drag: move\n"
    "  touch on (or Ctrl): drag the tool; the wheel pushes it deeper\n\n"
    "Space  play, pause\n"
    "T  touch on, off\n"
    "1 to 9  views: anterior, left, right, posterior, superior, inferior, short-axis, apex, "
    "four-chamber\n"
    "X  no cut, or the four-chamber one    [ and ]  move the cut by 2 mm\n"
    "V  volume off, muscle, blood\n"
    "R  reset    Ctrl+O  open    Ctrl+S  save a picture    Ctrl+E  export the plots as CSV\n"
    "F1  these keys\n\n"
    "\"Blood\" shows the bright cavities through the beat, not measured flow.\n"
    "For research and training. Not a medical device, not for diagnosis.";

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
  message_ = new QLabel;
  message_->setObjectName("message");
  message_->setWordWrap(true);
  message_->setStyleSheet("background: #7a3b12; color: white; padding: 6px;");
  message_->hide();
  told_ = new QLabel;
  told_->setObjectName("told");
  told_->setSizePolicy(QSizePolicy::Ignored, QSizePolicy::Preferred);  // a window may be small
  statusBar()->addWidget(told_, 1);

  auto* column = new QVBoxLayout;
  play_ = new QPushButton("Pause");
  play_->setObjectName("play");
  play_->setCheckable(true);
  play_->setChecked(true);
  rate_ = number("rate", 30, 220, " /min");
  phase_ = slider("phase", 0, kPhaseSteps, 0);
  view_ = choice("view", words_of(kViews));
  volume_ = choice("volume", {"off", "muscle", "blood"});
  colour_ = choice("colour", {"structures", "wall thickness", "stiffness", "AHA segments"});
  auto* beat = new QGroupBox("Beat and view");
  auto* beat_form = new QFormLayout(beat);
  beat_form->addRow(play_);
  beat_form->addRow("Heart rate", rate_);
  beat_form->addRow("Phase", phase_);
  beat_form->addRow("View", view_);
  beat_form->addRow("Volume", volume_);
  beat_form->addRow("Colour", colour_);
  column->addWidget(beat);

  QStringList cuts{"none"};
  cuts << words_of(kCuts) << "free";
  cut_ = choice("cut", cuts);
  cut_offset_ = slider("cut_offset", -80, 80, 0);
  cut_image_ = new QCheckBox("Image on the cut");
  cut_image_->setObjectName("cut_image");
  cut_image_->setChecked(true);
  auto* cutting = new QGroupBox("Cut");
  auto* cut_form = new QFormLayout(cutting);
  cut_form->addRow("Plane", cut_);
  cut_form->addRow("Move", cut_offset_);
  cut_form->addRow(cut_image_);
  column->addWidget(cutting);
  make_structures(column);

  touch_ = new QCheckBox("Touch with the mouse");
  touch_->setObjectName("touch");
  stiffness_ = number("stiffness", 10, 1000, " N/m");
  left_atrium_ = number("lap", 0, 40, " mmHg");
  preset_ = choice("preset", words_of(palpation::palpation_presets()));
  auto* reset_button = new QPushButton("Reset");
  reset_button->setObjectName("reset");
  auto* feel = new QGroupBox("Touch and circulation");
  auto* feel_form = new QFormLayout(feel);
  feel_form->addRow(touch_);
  feel_form->addRow("Stiffness", stiffness_);
  feel_form->addRow("Left atrium", left_atrium_);
  feel_form->addRow("Disease", preset_);
  feel_form->addRow(reset_button);
  column->addWidget(feel);
  column->addStretch(1);

  auto* controls = new QWidget;
  controls->setLayout(column);
  auto* scroll = new QScrollArea;  // a low window keeps its controls
  scroll->setWidget(controls);
  scroll->setWidgetResizable(true);
  scroll->setMinimumWidth(40);
  auto* splitter = new QSplitter;
  splitter->addWidget(scroll);
  splitter->addWidget(picture_);
  splitter->addWidget(plots_);
  splitter->setSizes({270, 620, 290});
  splitter->setStretchFactor(1, 1);
  auto* whole = new QWidget;
  auto* rows = new QVBoxLayout(whole);
  rows->setContentsMargins(0, 0, 0, 0);
  rows->addWidget(message_);
  rows->addWidget(splitter, 1);
  setCentralWidget(whole);
  setMinimumSize(200, 150);

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
      live_->touch().servo().set_paused(false);
      live_->touch().servo().hold_phase(std::min(phase, 0.999999));
    }
  });
  connect(view_, &QComboBox::currentTextChanged, this, [this](const QString& name) {
    HeartDrawing* drawing = picture_->drawing();
    if (drawing != nullptr) {
      drawing->set_camera(standard_view(drawing->frame(), name.toStdString()));
    }
  });
  connect(volume_, qOverload<int>(&QComboBox::currentIndexChanged), this, [this](int preset) {
    HeartDrawing* drawing = picture_->drawing();
    if (drawing != nullptr) drawing->set_volume(static_cast<VolumePreset>(preset));
  });
  connect(colour_, &QComboBox::currentTextChanged, this, [this] { colour_changed(); });
  connect(preset_, &QComboBox::currentTextChanged, this, [this] { stiffness_changed(); });
  connect(cut_, &QComboBox::currentTextChanged, this, [this] { cut_changed(); });
  connect(cut_offset_, &QSlider::valueChanged, this, [this] { cut_changed(); });
  connect(cut_image_, &QCheckBox::toggled, this, [this] { cut_changed(); });
  connect(touch_, &QCheckBox::toggled, this, [this](bool on) {
    picture_->set_touching(on);
    if (!on) lift_tool();
  });
  picture_->on_tool = [this](const Vec3& position_mm) { place_tool(position_mm); };
  connect(stiffness_, qOverload<int>(&QSpinBox::valueChanged), this, [this](int n_per_m) {
    guard([&] {
      if (live_) live_->touch().set_stiffness(n_per_m);
    });
  });
  connect(left_atrium_, qOverload<int>(&QSpinBox::valueChanged), this, [this](int mmhg) {
    guard([&] {
      if (live_) live_->touch().set_left_atrial_mmhg(mmhg);
    });
  });
  connect(preset_, &QComboBox::currentTextChanged, this, [this](const QString& name) {
    guard([&] {
      if (!live_) return;
      live_->touch().set_preset(name.toStdString());
      const QSignalBlocker quiet(left_atrium_);
      left_atrium_->setValue(
          static_cast<int>(std::lround(live_->touch().parameters().circulation.left_atrial_mmhg)));
    });
  });
  connect(reset_button, &QPushButton::clicked, this, [this] { reset(); });
}

void HeartWindow::make_structures(QVBoxLayout* column) {
  auto* group = new QGroupBox("Structures: seen, opaque");
  auto* form = new QFormLayout(group);
  for (const Structure structure : kAllStructures) {
    const std::string name(structure_name(structure));
    auto* seen = new QCheckBox(QString::fromStdString(structure_title(structure)));
    seen->setObjectName(QString::fromStdString("show_" + name));
    auto* opacity = slider(("opacity_" + name).c_str(), 0, 100, 100);
    form->addRow(seen);
    form->addRow(opacity);
    structures_[structure] = {seen, opacity};
    connect(seen, &QCheckBox::toggled, this, [this] { looks_changed(); });
    connect(opacity, &QSlider::valueChanged, this, [this] { looks_changed(); });
  }
  column->addWidget(group);
}

void HeartWindow::make_menus() {
  QMenu* file = menuBar()->addMenu("&File");
  file->addAction(
      "&Open...", this,
      [this] {
        const QString name =
            QFileDialog::getOpenFileName(this, "Open an atlas", {}, "Atlases (*.beatlas)");
        if (!name.isEmpty()) open(name);
      },
      QKeySequence::Open);
  recent_ = file->addMenu("Open &recent");
  connect(recent_, &QMenu::aboutToShow, this, [this] {
    recent_->clear();
    const QSettings settings("beatlas", "beatlas-view");
    for (const QString& name : settings.value("recent").toStringList()) {
      recent_->addAction(name, this, [this, name] { open(name); });
    }
  });
  file->addAction(
      "&Save a picture...", this,
      [this] {
        const QString name =
            QFileDialog::getSaveFileName(this, "Save a picture", "heart.png", "Pictures (*.png)");
        if (!name.isEmpty()) save_png(name);
      },
      QKeySequence::Save);
  file->addAction(
      "&Export the plots as CSV...", this,
      [this] {
        const QString name =
            QFileDialog::getSaveFileName(this, "Export the plots", "felt.csv", "Tables (*.csv)");
        if (!name.isEmpty()) save_csv(name);
      },
      QKeySequence("Ctrl+E"));
  file->addSeparator();
  file->addAction(
      "&Quit", this, [this] { close(); }, QKeySequence::Quit);
  QMenu* help = menuBar()->addMenu("&Help");
  help->addAction(
      "&Keys", this, [this] { QMessageBox::information(this, "Keys", kKeys); },
      QKeySequence::HelpContents);
}

void HeartWindow::make_shortcuts() {
  const auto on = [this](const char* keys, const std::function<void()>& action) {
    connect(new QShortcut(QKeySequence(keys), this), &QShortcut::activated, this, action);
  };
  on("Space", [this] { play_->toggle(); });
  on("T", [this] { touch_->toggle(); });
  on("R", [this] { reset(); });
  on("V", [this] { volume_->setCurrentIndex((volume_->currentIndex() + 1) % volume_->count()); });
  on("X", [this] { cut_->setCurrentIndex(cut_->currentIndex() == 0 ? 5 : 0); });
  on("[", [this] { cut_offset_->setValue(cut_offset_->value() - 2); });
  on("]", [this] { cut_offset_->setValue(cut_offset_->value() + 2); });
  for (int n = 0; n < view_->count(); ++n) {
    on(std::to_string(n + 1).c_str(), [this, n] { view_->setCurrentIndex(n); });
  }
}

}  // namespace beatlas::viewer
