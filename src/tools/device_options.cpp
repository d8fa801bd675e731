#include "device_options.h"

#include <ros/package.h>
#include <unistd.h>

#include "ring_gyro/configuration/configuration_reader.h"

namespace ring_gyro::tools {
namespace {

namespace options = boost::program_options;

std::string fileOfPreset(const std::string& preset) {
  const std::string package = ros::package::getPath("ring_gyro");
  if (package.empty()) {
    throw options::error(
        "--preset: the package is not found; source its setup.bash, or give the file with "
        "--config");
  }
  std::string file = package + "/config/" + preset + ".yaml";
  if (access(file.c_str(), R_OK) != 0) {
    throw options::error("no preset " + preset + "; presets are the files of " + package +
                         "/config without .yaml");
  }
  return file;
}

}  // namespace

void DeviceOptions::addTo(options::options_description& description) {
  description.add_options()(
      "config,c", options::value(&files_)->composing(),
      "YAML file: the sections converter, device, identification and extended are used")(
      "preset", options::value(&preset_), "config/NAME.yaml of this package, instead of --config")(
      "set", options::value(&overrides_)->composing(),
      "section/key=value, in place of what the file says; may be repeated");
}

cvg::LoopConfiguration DeviceOptions::read() const {
  if (!preset_.empty() && !files_.empty()) {
    throw options::error("--config and --preset exclude each other; give one");
  }
  if (!preset_.empty()) return cvg::readConfigurationFile(fileOfPreset(preset_), overrides_);
  if (files_.empty()) {
    throw options::error(
        "f0, Q and the block length of the device are not in a bag; add --config FILE or --preset "
        "NAME, such as --preset paper_experiment");
  }
  return cvg::readConfigurationFiles(files_, overrides_);
}

}  // namespace ring_gyro::tools
