from fullwell.errors import FullwellError as FullwellError
from fullwell.errors import RawFileError as RawFileError
from fullwell.errors import UsageError as UsageError
from fullwell.figures.results import Results as Results
from fullwell.figures.results import Row as Row
from fullwell.findings import Finding as Finding
from fullwell.findings import Severity as Severity
from fullwell.fit.channels import ChannelPoints as ChannelPoints
from fullwell.fit.channels import fit_shared_curve as fit_shared_curve
from fullwell.fit.noise_coefficients import fixed_pattern_test as fixed_pattern_test
from fullwell.fit.photon_transfer import fit_photon_transfer as fit_photon_transfer
from fullwell.fit.shading.data import ShadingData as ShadingData
from fullwell.fit.shading.selection import fit_shading as fit_shading
from fullwell.frames.selection import Selection as Selection
from fullwell.frames.series import Kind as Kind
from fullwell.raw.image import RawImage as RawImage
from fullwell.raw.open import read_raw as read_raw
from fullwell.report.reading import read_results as read_results
from fullwell.units import Measured as Measured
from fullwell.workflow.characterize import characterize as characterize
from fullwell.workflow.characterize import measure as measure
from fullwell.workflow.compare import compare_paths as compare_paths
from fullwell.workflow.fleet import characterize_fleet as characterize_fleet
from fullwell.workflow.options import CacheChoice as CacheChoice
from fullwell.workflow.options import Options as Options

__version__: str
