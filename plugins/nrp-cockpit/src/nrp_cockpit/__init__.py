"""The cockpit: a run in the browser, live or recorded.

A notebook shows a recording::

from nrp_cockpit import show

show("visit")
"""

from nrp_core.utilities import lazily

TYPE_CHECKING = False
if TYPE_CHECKING:
    from nrp_cockpit.notebook import PlayedRecording as PlayedRecording
    from nrp_cockpit.notebook import show as show
else:
    __getattr__, __dir__, __all__ = lazily(__name__)
