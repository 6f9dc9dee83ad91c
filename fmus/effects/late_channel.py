"""The delay of a channel against another one, of either sign.

    y(t) = y_0(t - d),   d < 0: the input is recorded late, as behind a slow sensor or a filter
"""

from fmus.declaration.variables import parameter
from fmus.effects.measuring_channel import ChannelDelay


class LateChannel(ChannelDelay):
    """The output is late, or the input where the delay is negative."""

    delay = parameter("s", "Delay of the output against the input", symbol="t_d", min=-0.2, max=0.2, start=0.0)
