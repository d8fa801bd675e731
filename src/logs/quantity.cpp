#include "ring_gyro/logs/quantity.h"

#include <boost/algorithm/string/predicate.hpp>
#include <cctype>

namespace ring_gyro {
namespace {

constexpr std::array<QuantityInfo, kQuantityCount> kQuantities = {{
    {Quantity::kTime, "t", Dimension::kTime, "time",
     " t time timestamp elapsed elapsedtime zeit temps "},
    {Quantity::kA, "a", Dimension::kVoltage, "major semi-axis",
     " a amp amplitude major majoraxis semimajor semimajoraxis orbita "},
    {Quantity::kB, "b", Dimension::kVoltage, "minor semi-axis",
     " b quad quadrature minor minoraxis semiminor semiminoraxis orbitb quadratureamplitude "},
    {Quantity::kTheta, "theta", Dimension::kAngle, "pattern angle",
     " theta angle patternangle precessionangle vibrationangle standingwaveangle winkel "},
    {Quantity::kPhi, "phi", Dimension::kAngle, "phase against the reference",
     " phi phase orbitphase pllphase "},
    {Quantity::kOmega, "omega", Dimension::kAngularRate, "reference frequency",
     " omega w f freq frequency fref fnco nco ncofrequency referencefrequency pllfrequency "
     "omegaref "
     "wref drivefrequency "},
    {Quantity::kBeta, "beta", Dimension::kTime, "sustain gain",
     " beta sustain sustaingain energygain betagain gainbeta "},
    {Quantity::kAlpha, "alpha", Dimension::kNone, "quadrature gain",
     " alpha quadgain quadraturegain alphagain gainalpha "},
    {Quantity::kVirtualRate, "virtual_rate", Dimension::kAngularRate,
     "steering, as a rotation of this rate",
     " virtualrate virtualrotation steeringrate steerrate steering steer omegas "},
    {Quantity::kCompensationGain1, "compensation_gain_1", Dimension::kTime, "compensation g1",
     " compensationgain1 g1 "},
    {Quantity::kCompensationGain2, "compensation_gain_2", Dimension::kTime, "compensation g2",
     " compensationgain2 g2 "},
    {Quantity::kSustainVolts, "sustain_volts", Dimension::kVoltage, "sustain drive, w beta a",
     " sustainvolts sustainvoltage sustaindrive sustainforce agc agcoutput energydrive "},
    {Quantity::kQuadratureVolts, "quadrature_volts", Dimension::kVoltage,
     "quadrature drive, alpha a",
     " quadraturevolts quadraturevoltage quadraturedrive quadratureforce quaddrive "},
    {Quantity::kSteeringVolts, "steering_volts", Dimension::kVoltage,
     "steering drive, across the pattern",
     " steeringvolts steeringvoltage steeringdrive steeringforce steerdrive "},
    {Quantity::kDriveXReal, "drive_x_real", Dimension::kVoltage, "total drive envelope",
     " drivexreal drivexre fxre fxreal fxcos "},
    {Quantity::kDriveXImag, "drive_x_imag", Dimension::kVoltage, "total drive envelope",
     " driveximag drivexim fxim fximag "},
    {Quantity::kDriveYReal, "drive_y_real", Dimension::kVoltage, "total drive envelope",
     " driveyreal driveyre fyre fyreal fycos "},
    {Quantity::kDriveYImag, "drive_y_imag", Dimension::kVoltage, "total drive envelope",
     " driveyimag driveyim fyim fyimag "},
    {Quantity::kCx, "cx", Dimension::kVoltage, "x in phase with cos", " cx xc xcos xi ix "},
    {Quantity::kSx, "sx", Dimension::kVoltage, "x in phase with sin", " sx xs xsin xq qx "},
    {Quantity::kCy, "cy", Dimension::kVoltage, "y in phase with cos", " cy yc ycos yi iy "},
    {Quantity::kSy, "sy", Dimension::kVoltage, "y in phase with sin", " sy ys ysin yq qy "},
    {Quantity::kX, "x", Dimension::kVoltage, "displacement sample",
     " x sensex xsense displacementx xdisplacement "},
    {Quantity::kY, "y", Dimension::kVoltage, "displacement sample",
     " y sensey ysense displacementy ydisplacement "},
    {Quantity::kReferencePhase, "psi", Dimension::kAngle, "phase of the reference",
     " psi referencephase ncophase "},
    {Quantity::kGroupDelay, "group_delay", Dimension::kTime, "of the demodulation",
     " groupdelay delay "},
    {Quantity::kUsable, "usable", Dimension::kNone, "1: locked and without fault",
     " usable valid locked "},
    {Quantity::kSequence, "sequence", Dimension::kNone, "number of the block", " sequence seq "},
}};

}  // namespace

const std::array<QuantityInfo, kQuantityCount>& quantities() { return kQuantities; }

const QuantityInfo& infoOf(Quantity quantity) { return kQuantities[indexOf(quantity)]; }

std::optional<Quantity> quantityFromName(std::string_view name) {
  for (const QuantityInfo& info : kQuantities) {
    if (boost::iequals(name, info.name)) return info.quantity;
  }
  return std::nullopt;
}

std::optional<Quantity> guessQuantity(std::string_view word) {
  std::string plain = " ";
  for (const char c : word) {
    const auto byte = static_cast<unsigned char>(c);
    if (std::isalnum(byte) != 0) plain += static_cast<char>(std::tolower(byte));
  }
  plain += ' ';
  if (plain.size() < 3) return std::nullopt;
  for (const QuantityInfo& info : kQuantities) {
    if (std::string_view(info.synonyms).find(plain) != std::string_view::npos) return info.quantity;
  }
  return std::nullopt;
}

}  // namespace ring_gyro
