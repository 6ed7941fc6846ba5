#include <QDesktopServices>
#include <QDir>
#include <QFileInfo>
#include <QFormLayout>
#include <QGroupBox>
#include <QLabel>
#include <QPushButton>
#include <QUrl>
#include <QVBoxLayout>
#include <cmath>

#include "runtime/viewer/heart_window.h"

namespace beatlas::viewer {
namespace {

constexpr double kPlaceMm = 1.5;  // radius of the ball at a place that is asked for

QString words_of(std::string_view text) {
  return QString::fromUtf8(text.data(), static_cast<int>(text.size()));
}

/// What is to be done, in words that stand beside the buttons.
QString task_of(const exercise::Exercise& asked) {
  if (asked.task == exercise::Task::Threshold) {
    return QString("One of %1 places is softer. Palpate them, then mark it; %2 times.")
        .arg(asked.places)
        .arg(asked.trials);
  }
  const QString what =
      asked.lesions == 1 ? QString("A lesion is") : QString("%1 lesions are").arg(asked.lesions);
  return what +
         " hidden in the left ventricle's wall. Palpate it, stay where it is, and mark what "
         "it is.";
}

}  // namespace

void HeartWindow::make_exercise(QVBoxLayout* column) {
  if (!options_.exercise) return;
  const exercise::Exercise asked = app::read_exercise(options_.exercise->exercise);
  const QString title = QString::fromStdString(asked.title);
  auto* group = new QGroupBox(title.isEmpty() ? QString("Exercise") : title);
  auto* rows = new QVBoxLayout(group);
  auto* task = new QLabel(task_of(asked));
  task->setWordWrap(true);
  rows->addWidget(task);
  exercise_told_ = new QLabel;
  exercise_told_->setObjectName("exercise_told");
  exercise_told_->setWordWrap(true);
  rows->addWidget(exercise_told_);
  for (std::size_t n = 0; n < asked.kinds.size(); ++n) {
    const QString kind = words_of(exercise::lesion_name(asked.kinds[n]));
    auto* mark = new QPushButton(QString("Mark as %1   Ctrl+%2").arg(kind).arg(n + 1));
    mark->setObjectName("mark_" + kind);
    mark->setShortcut(QKeySequence(QString("Ctrl+%1").arg(n + 1)));
    mark->setFocusPolicy(Qt::NoFocus);  // it is pressed while the tool is held
    connect(mark, &QPushButton::clicked, this, [this, n] {
      if (exercise_) exercise_->mark(n);
    });
    rows->addWidget(mark);
    mark_buttons_.push_back(mark);
  }
  exercise_report_ = new QPushButton("Open the report");
  exercise_report_->setObjectName("exercise_report");
  exercise_report_->hide();
  connect(exercise_report_, &QPushButton::clicked, this, [this] {
    const QDir folder(QString::fromStdString(options_.exercise->session));
    QDesktopServices::openUrl(
        QUrl::fromLocalFile(QFileInfo(folder, "report.html").absoluteFilePath()));
  });
  rows->addWidget(exercise_report_);
  column->addWidget(group);
}

void HeartWindow::begin_exercise() {
  exercise_ = std::make_unique<LiveExercise>(*options_.exercise, resting_place_mm());
  exercise_radius_mm_ = exercise_->exercise().tool_radius_mm;
  picture_->set_touching(exercise_->with_mouse());
  plots_->setVisible(plots_->isVisible() && exercise_->with_mouse());
}

// The tool as the exercise's servo has it, and what there is to do. Returns the phase of the beat.
double HeartWindow::show_exercise() {
  const LiveExercise::Seen seen = exercise_->seen();
  HeartDrawing& drawing = *picture_->drawing();
  std::vector<ToolPicture> tools;
  if (seen.playing) {
    ToolPicture tool = tool_picture_of(seen.servo, exercise_radius_mm_);
    drawing.set_beats(seen.servo.phase);
    picture_->set_field_time(seen.servo.phase * heart_->field->rr_interval_s());
    picture_->set_tool(tool.position_mm, tool.radius_mm);
    history_.add(press_row({.servo = seen.servo, .circulation = {}}));
    if (!exercise_->with_mouse()) tool.force_n = Vec3::Zero();
    tools.push_back(tool);
  }
  for (const Vec3& place_mm : seen.places_mm) {
    ToolPicture place;
    place.position_mm = place_mm;
    place.proxy_mm = place_mm;
    place.radius_mm = kPlaceMm;
    tools.push_back(place);
  }
  drawing.set_tools(std::move(tools));
  std::vector<Panel> panels = history_.panels();
  constexpr std::size_t kForceAndDepth = 2;
  panels.resize(std::min(panels.size(), kForceAndDepth));
  plots_->show_panels(std::move(panels));
  for (QPushButton* mark : mark_buttons_) mark->setEnabled(seen.playing && seen.servo.touching);
  if (seen.playing) {
    exercise_told_->setText(QString("Trial %1 of %2: mark %3 of %4, %5 s left")
                                .arg(seen.trial + 1)
                                .arg(exercise_->exercise().trial_count())
                                .arg(std::min(seen.made + 1, seen.marks))
                                .arg(seen.marks)
                                .arg(seen.seconds, 0, 'f', 0));
  }
  const std::optional<std::string> end = exercise_->take_end();
  if (end) {
    exercise_told_->setText(QString::fromStdString(*end));
    exercise_report_->setVisible(
        QFileInfo::exists(QString::fromStdString(options_.exercise->session) + "/report.html"));
  }
  return seen.servo.phase;
}

}  // namespace beatlas::viewer
