"""The delay between the channels of input and output, of either sign.

    y(t) = y_0(t - d),   d < 0: the input is recorded late, as behind a slow sensor or a filter
"""

from dataclasses import replace

from fmus.effects.measuring_channel import ChannelDelay


class LateChannel(ChannelDelay):
    """The output is recorded late, or the input where the delay is negative."""

    delay = replace(ChannelDelay.declared["delay"], min=-ChannelDelay.declared["delay"].max)
